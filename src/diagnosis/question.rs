//! What a diagnosis starts from.

use crate::effect::{Catalogue, Environment};
use crate::measurement::Dataset;
use crate::mechanism::Mechanism;
use crate::pose::PoseConvention;

/// Tolerances by which parameters may differ from the drawing.
pub(crate) const TOLERANCES: f64 = 2.0;

/// Input of a diagnosis.
#[derive(Clone, Debug)]
pub struct Question<'a> {
    /// The mechanism without effects.
    pub mechanism: &'a dyn Mechanism,
    /// The samples.
    pub data: &'a Dataset,
    /// Surroundings of the mechanism.
    pub environment: Environment,
    /// How the data write poses.
    pub convention: PoseConvention,
    /// The effects that are looked for.
    pub catalogue: Catalogue,
    /// True if the stated noise is taken as known; otherwise only its ratio of position to rotation is.
    pub noise_known: bool,
    /// Seed of the folds.
    pub seed: u64,
}
