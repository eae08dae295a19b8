//! Errors of a diagnosis.

use thiserror::Error;

use crate::identification::IdentifyError;
use crate::mechanism::GeometryError;

/// No diagnosis.
#[derive(Clone, Debug, Error)]
#[non_exhaustive]
pub enum DiagnoseError {
    /// The data leave nothing to look at after the kinematic parameters.
    #[error(
        "{samples} samples give {rows} equations, which leaves {free:.0} for the noise beside the parameters; at least \
         {needed} are needed to look for causes: measure more, and more varied, poses"
    )]
    TooFewRows {
        /// Samples.
        samples: usize,
        /// Rows.
        rows: usize,
        /// Remaining degrees of freedom.
        free: f64,
        /// Required degrees of freedom.
        needed: usize,
    },
    /// Every row is a place where something may have changed, so that time and memory grow faster than the rows.
    #[error(
        "{samples} samples are too many to search for causes, at most {most} are possible: diagnose parts of the run \
         separately, or average repeated samples"
    )]
    TooManySamples {
        /// Samples.
        samples: usize,
        /// The most that can be searched.
        most: usize,
    },
    /// Many samples do not agree with any model, so that none can be judged.
    #[error(
        "{outliers} of {samples} samples are inconsistent with the others, and the rest are too few to name a cause: \
         check the file"
    )]
    NothingFits {
        /// Samples that were left out.
        outliers: usize,
        /// All samples.
        samples: usize,
    },
    /// The baseline could not be identified.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// A mechanism of identified values does not exist.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A matrix that should be positive definite is not.
    #[error("the normal equations of the baseline are singular; state [tolerance], or measure more poses")]
    Singular,
}
