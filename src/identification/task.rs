//! What is to be identified, and how.

use crate::identification::problem::belief::Conventions;
use crate::identification::problem::prior::PriorPolicy;
use crate::measurement::Dataset;
use crate::mechanism::Mechanism;

/// How to weight the rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weights {
    /// By the covariance of the reading and of the joints.
    #[default]
    Noise,
    /// Not at all, on millimetres and radians: the paper's estimator.
    MillimetresAndRadians,
}

/// What an [`Identifier`](crate::identification::Identifier) works on.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// The mechanism; its values are the start and the centre of the prior.
    pub mechanism: &'a dyn Mechanism,
    /// The samples.
    pub data: &'a Dataset,
    /// Where priors come from.
    pub prior: PriorPolicy,
    /// How to weight the rows.
    pub weights: Weights,
    /// Conventions that are not those of the drawing, for a prior.
    pub conventions: Conventions,
}

impl<'a> Task<'a> {
    /// Identification of `mechanism` from `data`, weighted by the noise, with a prior where it is needed.
    pub fn new(mechanism: &'a dyn Mechanism, data: &'a Dataset) -> Self {
        Self { mechanism, data, prior: PriorPolicy::Auto, weights: Weights::Noise, conventions: Conventions::STATED }
    }
}
