//! How much a set of poses tells: observability indices and the fast scores behind pose selection.
//!
//! The stacked, scaled Jacobian `J` (6n × L) of `n` poses has singular values `σ₁ ≥ … ≥ σ_L`. An index condenses them
//! into one number:
//!
//! | name | index | asks for | bound |
//! |---|---|---|---|
//! | `o1` | [`O1`]: geometric mean of `σ`, over `√n` (eq. 34) | a small volume of uncertainty | yes |
//! | `o2` | [`O2`]: `σ_L/σ₁` (eq. 35) | a round ellipsoid | no |
//! | `o3` | [`O3`]: `σ_L` (eq. 36) | the worst direction | yes |
//! | `o4` | [`O4`]: `σ_L²/σ₁` (eq. 37) | both | no |
//! | `o5` | [`O5`]: `1/Σ 1/σᵢ` (eq. 38) | the mean uncertainty | yes |
//! | `pose-error` | [`PoseError`]: error of the calibrated pose where it will be used | what the user wants | yes |
//!
//! Indices depend on units, and so each value belongs to a [`Scaling`]. In mm and rad three directions (rotating all
//! platform points together) show up in angles only; they are a thousand times weaker than others whatever the poses
//! are, and O2, O3, O4 measure little else. Whitened rows and columns, the default, remove that.
//!
//! [`ObservabilityIndex`] is the trait; your own index needs one function of the [`Spectrum`]. [`Pool`] holds the
//! blocks of many candidates, [`PoseSet`] a set of them with the best addition and the best removal under an index. The
//! module works on blocks of rows and does not depend on mechanisms.

mod indices;
mod kernel;
mod pool;
mod pose_error;
mod pose_set;
mod prediction;
mod rows;
mod scaling;
mod spectrum;

use std::fmt::Debug;

use nalgebra::DMatrix;

pub use indices::{O1, O2, O3, O4, O5};
pub use kernel::Extremes;
pub(crate) use pool::PoolBuilder;
pub use pool::{Block, Pool};
pub use pose_error::PoseError;
pub use pose_set::{Best, PoseSet};
pub use prediction::{DECIDED, PredictedError};
pub use rows::stacked;
pub(crate) use rows::update_inverse;
pub use scaling::Scaling;
pub use spectrum::Spectrum;

/// Whether an index should be large or small.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Goal {
    /// Larger is better.
    Largest,
    /// Smaller is better.
    Smallest,
}

impl Goal {
    /// `a` is better than `b` by more than rounding.
    pub fn better(self, a: f64, b: f64) -> bool {
        match self {
            Self::Largest => a > b + 1e-12 * b.abs(),
            Self::Smallest => a < b - 1e-12 * b.abs() || (b.is_infinite() && a.is_finite()),
        }
    }

    /// A value as a score, of which the larger is the better.
    pub fn score(self, value: f64) -> f64 {
        match self {
            Self::Largest => value,
            Self::Smallest => -value,
        }
    }
}

/// An observability index.
pub trait ObservabilityIndex: Debug + Send + Sync {
    /// Name on the command line and in results.
    fn name(&self) -> &str;

    /// The index of a set of poses with this spectrum.
    fn value(&self, spectrum: &Spectrum) -> f64;

    /// Whether it should be large or small.
    fn goal(&self) -> Goal {
        Goal::Largest
    }

    /// True if [`value`](Self::value) reads [`Spectrum::directions`].
    fn needs_directions(&self) -> bool {
        false
    }

    /// True if the tolerances are known beforehand: unit rows in scaled parameters are then part of every set.
    fn prior(&self) -> bool {
        false
    }

    /// An equivalent form for which there are fast scans; without one every candidate costs a singular value
    /// decomposition.
    fn fast(&self) -> FastForm<'_> {
        FastForm::None
    }
}

/// The quantity of which an index is a monotone function, for a given number of poses. Whether larger or smaller is
/// better is the goal of the index.
#[derive(Clone, Copy, Debug)]
pub enum FastForm<'a> {
    /// The better, the larger `det JᵀJ` is.
    Determinant,
    /// The better, the larger a ratio of powers of the smallest and the largest singular value is.
    Extremes(Extremes),
    /// The better, the smaller `Σ 1/σᵢ` is.
    HarmonicSum,
    /// The better, the smaller `tr(G (JᵀJ)⁻¹)` is for this `G`.
    Trace(&'a DMatrix<f64>),
    /// None of these.
    None,
}

/// Names of the built-in indices.
pub const INDICES: [&str; 6] = ["o1", "o2", "o3", "o4", "o5", "pose-error"];

/// A built-in index by name, except `pose-error`, which needs targets.
pub fn index(name: &str) -> Option<Box<dyn ObservabilityIndex>> {
    Some(match name {
        "o1" => Box::new(O1),
        "o2" => Box::new(O2),
        "o3" => Box::new(O3),
        "o4" => Box::new(O4),
        "o5" => Box::new(O5),
        _ => return None,
    })
}
