//! Manufacturing tolerances as prior knowledge.

use nalgebra::DVector;

use super::IdentifyError;
use crate::mechanism::Mechanism;

/// A direction of the parameters counts as decided by the data if they determine it to a tenth of the tolerance.
pub const DECIDED: f64 = 10.0;

/// Where prior knowledge comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PriorPolicy {
    /// No prior while every singular value of the whitened, tolerance-scaled Jacobian is at least
    /// [`DECIDED`]; below that the tolerance is the prior.
    #[default]
    Auto,
    /// The tolerance is the prior.
    Tolerance,
    /// No prior.
    None,
}

/// Normal prior: each parameter lies about its start with its tolerance as 1σ.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior {
    /// Centre of each unknown.
    pub centre: DVector<f64>,
    /// 1σ of each unknown; infinite where nothing is known.
    pub sigma: DVector<f64>,
}

impl Prior {
    /// The tolerances of a mechanism about its values; `own` further unknowns have no prior.
    ///
    /// # Errors
    /// [`IdentifyError::NoTolerance`] if no parameter has one.
    pub fn from_tolerance(mechanism: &dyn Mechanism, own: usize) -> Result<Self, IdentifyError> {
        let specs = mechanism.parameters();
        if specs.iter().all(|s| s.tolerance.is_none()) {
            return Err(IdentifyError::NoTolerance);
        }
        let n = specs.len();
        let mut centre = DVector::zeros(n + own);
        let mut sigma = DVector::repeat(n + own, f64::INFINITY);
        for (k, spec) in specs.iter().enumerate() {
            centre[k] = mechanism.values()[k];
            sigma[k] = spec.tolerance.unwrap_or(f64::INFINITY);
        }
        Ok(Self { centre, sigma })
    }

    /// The unknowns that have a prior, with centre and σ.
    pub fn rows(&self) -> impl Iterator<Item = (usize, f64, f64)> + '_ {
        let finite = |k: &usize| self.sigma[*k].is_finite();
        (0..self.sigma.len()).filter(finite).map(|k| (k, self.centre[k], self.sigma[k]))
    }
}
