//! How well a calibrated model predicts poses.

use nalgebra::DMatrix;

/// A direction of the parameters counts as decided by the data if they determine it to a tenth of the tolerance.
pub const DECIDED: f64 = 10.0;

/// Predicted 1σ error of the calibrated pose over a set of poses.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PredictedError {
    /// Number of poses.
    pub poses: usize,
    /// RMS over the poses of the length of the position error, m.
    pub position_rms: f64,
    /// Largest of them, m.
    pub position_max: f64,
    /// RMS over the poses of the length of the rotation error, rad.
    pub rotation_rms: f64,
    /// Largest of them, rad.
    pub rotation_max: f64,
}

/// Blocks whose products are taken together.
const AT_A_TIME: usize = 50;

impl PredictedError {
    /// With all errors this many times as large.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self {
            position_rms: factor * self.position_rms,
            position_max: factor * self.position_max,
            rotation_rms: factor * self.rotation_rms,
            rotation_max: factor * self.rotation_max,
            ..self
        }
    }

    /// For blocks (6 × L: motion of a point, small rotation, per parameter) at the poses, and the covariance (L × L) of
    /// the parameters: `J_b Cov J_bᵀ` at each.
    pub fn over(blocks: &[DMatrix<f64>], covariance: &DMatrix<f64>) -> Self {
        let mut position = Vec::with_capacity(blocks.len());
        let mut rotation = Vec::with_capacity(blocks.len());
        // One product of large matrices is cheaper than many of small ones.
        for blocks in blocks.chunks(AT_A_TIME) {
            let mut rows = DMatrix::zeros(6 * blocks.len(), covariance.nrows());
            for (k, block) in blocks.iter().enumerate() {
                rows.rows_mut(6 * k, 6).copy_from(block);
            }
            let variance = (&rows * covariance).component_mul(&rows).column_sum();
            for k in 0..blocks.len() {
                position.push(variance.rows(6 * k, 3).sum());
                rotation.push(variance.rows(6 * k + 3, 3).sum());
            }
        }
        let rms = |v: &[f64]| (v.iter().sum::<f64>() / v.len() as f64).sqrt();
        let max = |v: &[f64]| v.iter().copied().fold(0.0, f64::max).sqrt();
        Self {
            poses: blocks.len(),
            position_rms: rms(&position),
            position_max: max(&position),
            rotation_rms: rms(&rotation),
            rotation_max: max(&rotation),
        }
    }
}
