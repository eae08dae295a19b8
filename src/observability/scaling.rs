//! The units in which an index is taken.

use serde::{Deserialize, Serialize};

use crate::units::Dimension;

/// How rows and columns of a Jacobian are scaled before an index is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scaling {
    /// Millimetres and radians, unweighted, as in the paper.
    Paper,
    /// Rows divided by the noise, columns multiplied by the tolerance: a singular value is the tolerance over the
    /// uncertainty along its direction.
    Whitened,
}

impl Scaling {
    /// As written on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Whitened => "whitened",
        }
    }

    /// Factor of the column of a parameter, SI per scaled unit; `None` if a tolerance is missing.
    pub fn column(self, dimension: Dimension, tolerance: Option<f64>) -> Option<f64> {
        match self {
            Self::Paper => Some(if dimension == Dimension::Length { 1e-3 } else { 1.0 }),
            Self::Whitened => tolerance.filter(|t| *t > 0.0),
        }
    }
}
