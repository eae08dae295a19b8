//! `[calibration]`: what a written mechanism file says of the calibration that it came from.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::diagnosis::{Diagnosis, Verdict};
use crate::files::machine::Machine;
use crate::files::mechanism::toml_text::{line, list, quoted};
use crate::files::table::writer::number;
use crate::identification::Calibration;
use crate::observability::PredictedError;

/// Name and version of the program.
const PROGRAM: &str = concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION"));

/// `[calibration]` of a written mechanism file; all keys are optional.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibrationSection {
    /// Name and version of the program.
    pub program: Option<String>,
    /// SHA-256 of the measurement file.
    pub data_sha256: Option<String>,
    /// SHA-256 of the mechanism file that was calibrated.
    pub drawing_sha256: Option<String>,
    /// Number of data rows.
    pub rows: Option<usize>,
    /// Frame of the geometry: `measurement` or `base`.
    pub frame: Option<String>,
    /// False if the result must not be trusted; commands are then made with `--force` only.
    pub trusted: Option<bool>,
    /// Why it must not.
    #[serde(default)]
    pub reasons: Vec<String>,
    /// Observed noise over the stated one.
    pub noise_scale: Option<f64>,
    /// Predicted 1σ of the pose over the workspace, SI.
    #[serde(default)]
    pub predicted: BTreeMap<String, f64>,
    /// Names of the parameters of the covariance.
    #[serde(default)]
    pub names: Vec<String>,
    /// Rows of a lower factor of the covariance of the parameters, SI.
    #[serde(default)]
    pub covariance_factor: Vec<Vec<f64>>,
}

impl CalibrationSection {
    /// What a calibration of a `machine` with so many data rows says of the file that is made of it.
    pub fn of_calibration(result: &Calibration, machine: &Machine) -> Self {
        let elsewhere = result.registration.applied || machine.is_in_frame_of_measurement();
        let predicted = result.predicted.as_ref().filter(|_| result.verdict.trusted);
        let keys = |p: &PredictedError| {
            [("position_m", p.position_rms), ("rotation_rad", p.rotation_rms)].map(|(k, v)| (k.to_owned(), v))
        };
        Self {
            noise_scale: result.identification.misfit.scale(),
            predicted: predicted.map(keys).into_iter().flatten().collect(),
            ..Self::of(result.identification.poses.len(), elsewhere, result.verdict.trusted, &result.verdict.reasons)
        }
    }

    /// What a diagnosis of a `machine` with so many data rows says of the extended file; it predicts no errors.
    pub fn of_diagnosis(found: &Diagnosis, machine: &Machine, rows: usize) -> Self {
        let elsewhere = !found.frames.is_identity() || machine.is_in_frame_of_measurement();
        let reasons = match found.verdict {
            Verdict::Unknown => vec!["the diagnosis found something that no effect of the model explains".to_owned()],
            Verdict::Undecided => vec!["the data of the diagnosis cannot tell whether the model is right".to_owned()],
            _ => Vec::new(),
        };
        Self::of(rows, elsewhere, reasons.is_empty(), &reasons)
    }

    fn of(rows: usize, elsewhere: bool, trusted: bool, reasons: &[String]) -> Self {
        Self {
            program: Some(PROGRAM.into()),
            rows: Some(rows),
            frame: Some(if elsewhere { "measurement" } else { "base" }.into()),
            trusted: Some(trusted),
            reasons: reasons.to_vec(),
            ..Self::default()
        }
    }

    /// What the file is, in the words of a comment.
    pub fn in_words(&self) -> String {
        let rows = self.rows.map_or_else(String::new, |rows| format!(" from {rows} data rows"));
        let frame = match self.frame.as_deref() {
            Some("measurement") => ", in the frame of the measurement",
            Some("base") => ", in the frame of the base",
            _ => "",
        };
        let trusted = match self.trusted {
            Some(true) => ", trusted",
            Some(false) => ", NOT to be trusted",
            None => "",
        };
        format!("model{rows}{frame}{trusted}")
    }

    pub(super) fn to_text(&self) -> String {
        let text = |key: &str, value: &Option<String>| line(key, value.as_ref().map(|v| quoted(v)));
        let strings = |key: &str, values: &[String]| {
            let all: Vec<String> = values.iter().map(|v| quoted(v)).collect();
            line(key, (!all.is_empty()).then(|| format!("[{}]", all.join(", "))))
        };
        let mut all = "\n[calibration]\n".to_owned();
        all += &text("program", &self.program);
        all += &text("data_sha256", &self.data_sha256);
        all += &text("drawing_sha256", &self.drawing_sha256);
        all += &line("rows", self.rows.map(|rows| rows.to_string()));
        all += &text("frame", &self.frame);
        all += &line("trusted", self.trusted.map(|trusted| trusted.to_string()));
        all += &strings("reasons", &self.reasons);
        all += &line("noise_scale", self.noise_scale.map(number));
        let predicted: Vec<String> =
            self.predicted.iter().map(|(k, v)| format!("{} = {}", quoted(k), number(*v))).collect();
        all += &line("predicted", (!predicted.is_empty()).then(|| format!("{{ {} }}", predicted.join(", "))));
        all += &strings("names", &self.names);
        let rows: Vec<String> = self.covariance_factor.iter().map(|row| format!("  {},\n", list(row))).collect();
        all + &line("covariance_factor", (!rows.is_empty()).then(|| format!("[\n{}]", rows.concat())))
    }
}
