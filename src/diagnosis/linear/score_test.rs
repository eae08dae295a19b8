//! A block of columns that is asked beside a model: what it would gain, and how likely it makes the data.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricEigen};

use crate::diagnosis::linear::statistics::{Noise, log_mean};
use crate::solve::symmetric_eigen;

/// A block of columns beside a model.
#[derive(Clone, Debug)]
pub(crate) struct ScoreTest {
    /// `S` (p × p).
    pub(crate) s: DMatrix<f64>,
    /// `c` (p).
    pub(crate) c: DVector<f64>,
    /// Lengths squared of the columns before the projection.
    pub(crate) raw: DVector<f64>,
}

/// Projected columns shorter than this part of what they were, squared, are rounding.
pub(crate) const ABSORBED: f64 = 1e-8;
/// Widths of the prior over the usual size of a parameter, an equal mixture: sound machines and broken ones.
const WIDTHS: [f64; 4] = [0.3, 1.0, 3.0, 10.0];

impl ScoreTest {
    /// Rows that repeat each other count for less: every sum over rows is divided by `inflation`.
    pub(crate) fn of(square: &DMatrix<f64>, s: &DMatrix<f64>, c: &DVector<f64>, inflation: f64) -> Self {
        Self { s: s / inflation, c: c / inflation, raw: square.diagonal() / inflation }
    }

    /// What the block takes off the sum of squares, and how many directions of it the data see.
    pub(crate) fn gain(&self) -> (f64, usize) {
        let p = self.c.len();
        if p == 1 {
            let seen = self.s[(0, 0)] > ABSORBED * self.raw[0];
            return if seen { (self.c[0] * self.c[0] / self.s[(0, 0)], 1) } else { (0.0, 0) };
        }
        let (eigen, scale) = self.normalized();
        let along = eigen.eigenvectors.tr_mul(&self.c.component_div(&scale));
        let seen = |value: f64| value > ABSORBED;
        let pairs = along.iter().zip(eigen.eigenvalues.iter()).filter(|(_, v)| seen(**v));
        pairs.fold((0.0, 0), |(gain, rank), (a, v)| (gain + a * a / v, rank + 1))
    }

    /// The values that the block would take; directions that the data do not see stay at zero.
    pub(crate) fn values(&self) -> Vec<f64> {
        let (eigen, scale) = self.normalized();
        let mut values = DVector::zeros(scale.len());
        let along = eigen.eigenvectors.tr_mul(&self.c.component_div(&scale));
        for (k, value) in eigen.eigenvalues.iter().enumerate().filter(|(_, v)| **v > ABSORBED) {
            values.axpy(-along[k] / value, &eigen.eigenvectors.column(k), 1.0);
        }
        values.component_div(&scale).iter().copied().collect()
    }

    fn normalized(&self) -> (SymmetricEigen<f64, Dyn>, DVector<f64>) {
        let scale = self.raw.map(|v| if v > 0.0 { v.sqrt() } else { 1.0 });
        let mut s = self.s.clone();
        for k in 0..scale.len() {
            s.row_mut(k).unscale_mut(scale[k]);
            s.column_mut(k).unscale_mut(scale[k]);
        }
        (symmetric_eigen(s), scale)
    }

    /// Logarithm of the marginal likelihood over that of no effect: Gaussian priors with the usual sizes of the
    /// parameters, in a mixture of widths, and the size of the noise profiled out.
    pub(crate) fn evidence(&self, scales: &[f64], noise: &Noise) -> f64 {
        let (gain, rank) = self.gain();
        let variance = noise.variance_after(gain, rank as f64);
        let p = self.c.len();
        let of_width = |width: f64| {
            // In units of the prior: D½ S D½ + σ² I.
            let d = DVector::from_iterator(p, scales.iter().map(|s| s * width));
            let b =
                DMatrix::from_fn(p, p, |i, j| d[i] * self.s[(i, j)] * d[j] / variance + if i == j { 1.0 } else { 0.0 });
            let c = self.c.component_mul(&d) / variance;
            let Some(cholesky) = Cholesky::new(b) else { return f64::NEG_INFINITY };
            // cᵀ (S + σ² D⁻¹)⁻¹ c / σ² with both in units of the prior.
            let q = c.dot(&cholesky.solve(&c));
            let log_det: f64 = cholesky.l_dirty().diagonal().iter().map(|v| 2.0 * v.ln()).sum();
            let fit = match noise.known {
                true => 0.5 * q,
                false => {
                    let part = (q * variance / noise.objective).min(1.0 - 1e-15);
                    -0.5 * noise.dof * (-part).ln_1p()
                }
            };
            fit - 0.5 * log_det
        };
        log_mean(&WIDTHS.map(of_width))
    }
}
