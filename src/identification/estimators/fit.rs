//! What an identifier finds.

use nalgebra::DVector;

use crate::measurement::SamplePosition;
use crate::solve::{Convergence, IterationRecord, LeastSquaresSolution};

/// The values that fit the rows of a problem best, and how they were reached. Prior and size of the noise are those of the
/// problem; what the values are worth is judged afterwards.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Parameters of the mechanism, then those of the measurement, SI.
    pub values: DVector<f64>,
    /// Weight of each sample; below one only in robust fits.
    pub weights: Vec<f64>,
    /// Samples that a robust fit takes for gross errors.
    pub gross: Vec<SamplePosition>,
    /// Accepted steps.
    pub history: Vec<IterationRecord>,
    /// Why the iteration ended.
    pub convergence: Convergence,
}

impl Fit {
    /// Of a solution for so many samples, each at its full weight.
    pub fn new(solution: &LeastSquaresSolution, samples: usize) -> Self {
        Self {
            values: solution.x.clone(),
            weights: vec![1.0; samples],
            gross: Vec::new(),
            history: solution.history.clone(),
            convergence: solution.convergence,
        }
    }
}
