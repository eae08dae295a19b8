//! The operating state of one sample: what was true while it was measured.
//!
//! A plain mechanism ignores it. Effects such as thermal growth, gravity or backlash act on it, and the
//! diagnosis looks through it for what the residuals depend on.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::Vector3;

/// Covariates of one sample by name, and the joints of the samples before.
///
/// Covariates are named by their column without the unit: `temp_leg3`, `elevation`, `time`, `payload`, or
/// any other numeric column of the measurement file. Values are in SI, temperatures in °C.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Conditions {
    /// Value of each covariate that is known.
    pub covariates: BTreeMap<String, f64>,
    /// Joint coordinates of the sample that was measured before, in file order; home for the first one.
    pub previous_joints: Option<Vec<f64>>,
    /// Direction of gravity in the base frame, length one.
    pub gravity: Option<Vector3<f64>>,
    /// Place of the sample in its run; `None` outside of one.
    pub run: Option<Run>,
}

/// Place of a sample in the run in which it was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// 0-based data row.
    pub row: usize,
    /// Part of the run that has passed: 0 at the first row, 1 at the last, by time, or by rows without it.
    pub part: f64,
    /// Joint coordinates of all rows of the run, in file order.
    pub joints: Arc<[Vec<f64>]>,
}

impl Conditions {
    /// Conditions of which nothing is known.
    pub fn unknown() -> Self {
        Self::default()
    }

    /// The value of a covariate, if it is known.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.covariates.get(name).copied()
    }

    /// Mean temperature of the legs, °C: `temp_legs`, or the mean of `temp_leg1` ….
    pub fn leg_temperature(&self) -> Option<f64> {
        if let Some(t) = self.get("temp_legs") {
            return Some(t);
        }
        let own = self.covariates.range("temp_leg".to_owned()..).take_while(|(k, _)| k.starts_with("temp_leg"));
        let (sum, count) = own
            .filter(|(k, _)| k["temp_leg".len()..].parse::<usize>().is_ok())
            .fold((0.0, 0), |(sum, count), (_, t)| (sum + t, count + 1));
        (count > 0).then(|| sum / f64::from(count))
    }
}
