//! `[calibration]`: what a written mechanism file says of the calibration that it came from.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::files::mechanism::toml_text::{line, list, quoted};
use crate::files::table::writer::number;

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
