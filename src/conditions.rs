//! The operating state of one sample: what was true while it was measured.
//!
//! A plain mechanism ignores it. Effects such as thermal growth, gravity or backlash act on it, and the
//! diagnosis looks through it for what the residuals depend on.

use std::collections::BTreeMap;

/// Covariates of one sample by name, and the joints of the sample before.
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
}
