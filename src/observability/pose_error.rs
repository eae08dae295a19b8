//! The error of the calibrated pose that a set of poses leads to.

use nalgebra::{DMatrix, DVector};

use super::{FastForm, Goal, ObservabilityIndex, Spectrum};

/// `√(mean over targets of tr(W J_b Cov J_bᵀ W))` with `W = 1/σ` of the six coordinates: how large the error of the
/// calibrated pose will be at the poses that the user cares for, in units of the noise of one coordinate (six for a
/// pose as uncertain as one measurement, √6). Smaller is better (V-optimality).
///
/// `Cov` is `(JᵀJ)⁻¹` for whitened rows, or `(JᵀJ + I)⁻¹` if the tolerances are a prior: with columns in units of the
/// tolerance the prior is the identity.
#[derive(Clone, Debug)]
pub struct PoseError {
    /// `G = mean J_bᵀ W² J_b` (L' × L') in scaled parameters along the visible directions.
    gain: DMatrix<f64>,
    prior: bool,
}

impl PoseError {
    /// For blocks `W J_b` (6 × L) of the targets with scaled columns; `visible` (L × L') are the directions that
    /// candidates see, see [`Pool::visible`](super::Pool::visible).
    pub fn new(targets: &[DMatrix<f64>], visible: &DMatrix<f64>, prior: bool) -> Self {
        let mut gain = DMatrix::zeros(visible.ncols(), visible.ncols());
        for block in targets {
            let seen = block * visible;
            gain += seen.transpose() * &seen / targets.len().max(1) as f64;
        }
        Self { gain, prior }
    }

    /// This index with or without the tolerances as prior.
    pub fn with_prior(&self, prior: bool) -> Self {
        Self { prior, ..self.clone() }
    }
}

impl ObservabilityIndex for PoseError {
    fn name(&self) -> &str {
        "pose-error"
    }

    fn goal(&self) -> Goal {
        Goal::Smallest
    }

    fn value(&self, s: &Spectrum) -> f64 {
        let along = |k: usize| {
            let v: DVector<f64> = s.directions.column(k).into_owned();
            (v.transpose() * &self.gain * &v)[(0, 0)]
        };
        (0..s.values.len()).map(|k| along(k) / s.values[k].powi(2)).sum::<f64>().sqrt()
    }

    fn needs_directions(&self) -> bool {
        true
    }

    fn prior(&self) -> bool {
        self.prior
    }

    fn fast(&self) -> FastForm<'_> {
        FastForm::Trace(&self.gain)
    }
}
