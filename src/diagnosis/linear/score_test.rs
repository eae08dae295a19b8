//! A block of columns that is asked beside a model: what it would gain, and how likely it makes the data.

use nalgebra::{DMatrix, DVector, Dyn, SymmetricEigen};

use crate::diagnosis::linear::statistics::{Noise, log_mean};
use crate::solve::{SmallCholesky, symmetric_eigen};

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
/// Determinant of the projected columns, in units of their lengths before, from which on no direction is near that limit.
pub(crate) const PLAINLY_SEEN: f64 = 1e-6;
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
        if let Some(gain) = self.gain_of_all() {
            return (gain, p);
        }
        let (eigen, scale) = self.normalized();
        let along = eigen.eigenvectors.tr_mul(&self.c.component_div(&scale));
        let seen = |value: f64| value > ABSORBED;
        let pairs = along.iter().zip(eigen.eigenvalues.iter()).filter(|(_, v)| seen(**v));
        pairs.fold((0.0, 0), |(gain, rank), (a, v)| (gain + a * a / v, rank + 1))
    }

    /// The gain if the data plainly see all directions, by a Cholesky factor. Columns of unit length leave a matrix with a
    /// trace of at most `p`, so that `p - 1` of its eigenvalues multiply to no more than `(p / (p - 1))^(p - 1) < e`, and
    /// the least of them is at least the determinant over `e`.
    fn gain_of_all(&self) -> Option<f64> {
        let scale = self.raw.map(f64::sqrt);
        let factor = SmallCholesky::of(scale.len(), |i, k| self.s[(i, k)] / (scale[i] * scale[k]))?;
        let determinant: f64 = factor.diagonal().map(|d| d * d).product();
        (determinant > PLAINLY_SEEN).then(|| factor.form(&self.c.component_div(&scale)))
    }

    /// The block along one direction of its columns.
    pub(crate) fn along(&self, direction: &[f64]) -> Self {
        let d = DVector::from_column_slice(direction);
        let one = |value: f64| DVector::from_element(1, value);
        Self {
            s: DMatrix::from_element(1, 1, (&self.s * &d).dot(&d)),
            c: one(self.c.dot(&d)),
            raw: one(d.iter().zip(&self.raw).map(|(d, raw)| d * d * raw).sum()),
        }
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

    /// Scores (p × any number) along the directions that the data see, each in units of its length.
    pub(crate) fn along_seen(&self, scores: &DMatrix<f64>) -> DMatrix<f64> {
        let (eigen, scale) = self.normalized();
        let seen: Vec<usize> = (0..scale.len()).filter(|k| eigen.eigenvalues[*k] > ABSORBED).collect();
        let mut directions = eigen.eigenvectors.select_columns(&seen);
        for (mut column, k) in directions.column_iter_mut().zip(&seen) {
            column.component_div_assign(&scale);
            column.unscale_mut(eigen.eigenvalues[*k].sqrt());
        }
        directions.tr_mul(scores)
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
    /// parameters, in a mixture of widths, and the size of the noise profiled out. `gain` and `rank` are those of
    /// [`gain`](Self::gain).
    pub(crate) fn evidence(&self, (gain, rank): (f64, usize), scales: &[f64], noise: &Noise) -> f64 {
        let variance = noise.variance_after(gain, rank as f64);
        let mut c = DVector::zeros(scales.len());
        let of_width = |width: f64| {
            // In units of the prior: D½ S D½ + σ² I.
            let d = |i: usize| scales[i] * width;
            let entry = |i: usize, k: usize| d(i) * self.s[(i, k)] * d(k) / variance + if i == k { 1.0 } else { 0.0 };
            let Some(factor) = SmallCholesky::of(scales.len(), entry) else { return f64::NEG_INFINITY };
            // cᵀ (S + σ² D⁻¹)⁻¹ c / σ² with both in units of the prior.
            c.iter_mut().enumerate().for_each(|(i, c)| *c = self.c[i] * d(i) / variance);
            let q = factor.form(&c);
            let log_det: f64 = factor.diagonal().map(|v| 2.0 * v.ln()).sum();
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The short way and the decomposition give the same gain where all directions are seen.
    #[test]
    fn the_gain_is_that_of_the_pseudo_inverse() {
        for p in [2, 3, 6, 12] {
            let x = DMatrix::from_fn(5 * p, p, |i, k| ((7 * i + 11 * k * k + 3 * i * k) % 31) as f64 - 15.0);
            let square = x.tr_mul(&x);
            let c = DVector::from_fn(p, |k, _| 40.0 * (k as f64 - 1.2));
            let asked = ScoreTest::of(&square, &(&square * 0.4), &c, 1.0);
            let wanted = c.dot(&(asked.s.clone().pseudo_inverse(1e-12).unwrap() * &c));
            let (gain, rank) = asked.gain();
            assert_eq!(rank, p);
            assert!((gain - wanted).abs() < 1e-9 * wanted, "{p}: {gain} {wanted}");
            // A column twice is one direction.
            let twice = DMatrix::from_fn(5 * p, p + 1, |i, k| x[(i, k.min(p - 1))]);
            let square = twice.tr_mul(&twice);
            let c = DVector::from_fn(p + 1, |k, _| c[k.min(p - 1)]);
            let (again, rank) = ScoreTest::of(&square, &(&square * 0.4), &c, 1.0).gain();
            assert_eq!(rank, p);
            assert!((again - gain).abs() < 1e-9 * gain);
        }
    }
}
