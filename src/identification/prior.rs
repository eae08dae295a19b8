//! Manufacturing tolerances as prior knowledge.

use nalgebra::{DMatrix, DVector};

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

/// What is known of the unknowns beside the data, as further rows of the least-squares problem.
#[derive(Clone, Debug, PartialEq)]
pub enum Prior {
    /// Each parameter lies about its start with its tolerance as 1σ.
    Tolerance {
        /// Centre of each parameter of the mechanism.
        centre: Vec<f64>,
        /// 1σ of each; infinite where nothing is known.
        sigma: Vec<f64>,
    },
    /// Directions that no row sees stay at their start. This brings no knowledge in, and the directions are
    /// reported as undetermined.
    Held {
        /// Start of each parameter of the mechanism.
        centre: Vec<f64>,
        /// Scale of each parameter.
        scale: Vec<f64>,
        /// The directions as columns, in parameters over their scale.
        directions: DMatrix<f64>,
    },
}

/// How firmly unseen directions are held, as a part of the scale.
const HOLD: f64 = 1e-3;

impl Prior {
    /// The tolerances of a mechanism about its values.
    ///
    /// # Errors
    /// [`IdentifyError::NoTolerance`] if no parameter has one.
    pub fn from_tolerance(mechanism: &dyn Mechanism) -> Result<Self, IdentifyError> {
        let specs = mechanism.parameters();
        if specs.iter().all(|s| s.tolerance.is_none()) {
            return Err(IdentifyError::NoTolerance);
        }
        let sigma = specs.iter().map(|s| s.tolerance.unwrap_or(f64::INFINITY)).collect();
        Ok(Self::Tolerance { centre: mechanism.values().to_vec(), sigma })
    }

    /// Holds directions (columns, in parameters over their scale) at the values of a mechanism.
    pub fn holding(mechanism: &dyn Mechanism, scale: Vec<f64>, directions: DMatrix<f64>) -> Self {
        Self::Held { centre: mechanism.values().to_vec(), scale, directions }
    }

    /// True if it brings knowledge in; false if it only holds what no row sees.
    pub fn informs(&self) -> bool {
        matches!(self, Self::Tolerance { .. })
    }

    /// Number of its rows.
    pub fn rows(&self) -> usize {
        match self {
            Self::Tolerance { sigma, .. } => sigma.iter().filter(|s| s.is_finite()).count(),
            Self::Held { directions, .. } => directions.ncols(),
        }
    }

    /// Writes its rows at `x` from row `first` on: `(x - x₀)/σ` with unit variance.
    pub fn write(&self, x: &DVector<f64>, first: usize, residual: &mut DVector<f64>, jacobian: &mut DMatrix<f64>) {
        jacobian.rows_mut(first, self.rows()).fill(0.0);
        match self {
            Self::Tolerance { centre, sigma } => {
                let finite = sigma.iter().enumerate().filter(|(_, s)| s.is_finite());
                for (row, (k, s)) in finite.enumerate() {
                    residual[first + row] = (x[k] - centre[k]) / s;
                    jacobian[(first + row, k)] = 1.0 / s;
                }
            }
            Self::Held { centre, scale, directions } => {
                for (row, direction) in directions.column_iter().enumerate() {
                    let mut sum = 0.0;
                    for (k, v) in direction.iter().enumerate() {
                        let weight = v / (scale[k] * HOLD);
                        sum += weight * (x[k] - centre[k]);
                        jacobian[(first + row, k)] = weight;
                    }
                    residual[first + row] = sum;
                }
            }
        }
    }
}
