//! Why an identification has no result.

use thiserror::Error;

use crate::identification::estimators::fit::Fit;
use crate::measurement::DataRow;
use crate::mechanism::{GeometryError, KinematicsError};
use crate::solve::SolveError;

/// Why an identification has no result.
#[derive(Clone, Debug, Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// No sample, or none with a reading.
    #[error("the data contain no readings; add rows with a measured pose or targets")]
    Empty,
    /// Too few rows, and no prior to make up for them.
    #[error(
        "{rows} equations ({samples} samples) cannot determine {unknowns} parameters; measure at least \
         {needed} samples like these, or state a [tolerance] and allow a prior"
    )]
    TooFewRows {
        /// Rows of the data.
        rows: usize,
        /// Samples.
        samples: usize,
        /// Parameters to identify.
        unknowns: usize,
        /// Samples of this kind that would do.
        needed: usize,
    },
    /// A prior was asked for, and no parameter has a tolerance.
    #[error("a prior was requested, but the mechanism has no [tolerance]; state one, or calibrate without a prior")]
    NoTolerance,
    /// A prior has no meaning with unweighted rows.
    #[error("a prior needs rows weighted by their noise; drop `--weights none` or `--prior tolerance`")]
    PriorWithoutWeights,
    /// A measurement model has no start for its own parameters.
    #[error("the measurement has {expected} parameters of its own, but {found} finite starting values")]
    Start {
        /// Parameters of the measurement.
        expected: usize,
        /// Start values it gave.
        found: usize,
    },
    /// The kinematics fails at one sample.
    #[error("data row {row}{label}: {cause}")]
    Sample {
        /// The sample.
        row: DataRow,
        /// ` (id)`, or nothing.
        label: String,
        /// The failure.
        cause: KinematicsError,
    },
    /// The covariance of one sample cannot be used.
    #[error("data row {row}: the noise of its reading is not positive")]
    Covariance {
        /// The sample.
        row: DataRow,
    },
    /// The iterations were used up. Where they led is kept, so that it can be shown, but it is no result.
    #[error("{cause}")]
    NotConverged {
        /// Error of the solver.
        cause: SolveError,
        /// Where the iteration stood.
        last: Box<Fit>,
    },
    /// The iteration failed.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// The identified values are no mechanism.
    #[error("the identified parameters do not form a valid mechanism: {0}")]
    Geometry(#[from] GeometryError),
    /// The data that were set apart to check the result cannot be used.
    #[error("held-out data: {0}")]
    HeldOut(Box<IdentifyError>),
    /// An identifier of a consumer failed.
    #[error("{0}")]
    Other(String),
}

impl IdentifyError {
    /// Of a solver for so many samples: where it stood is kept if it only ran out of iterations.
    pub fn without_minimum(cause: SolveError, samples: usize) -> Self {
        match &cause {
            SolveError::NoConvergence { last, .. } => {
                let last = Box::new(Fit::new(last, samples));
                Self::NotConverged { cause, last }
            }
            _ => cause.into(),
        }
    }
}
