//! Errors on rows that were not fitted.
//!
//! Where the rows `f` of a fold are left out of a linear fit, the error with which they are then predicted is
//! `(I - Q_f Q_fᵀ)⁻¹ r_f = r_f + Q_f (I - Q_fᵀ Q_f)⁻¹ Q_fᵀ r_f`, so that no fold is fitted again. The models are linear to
//! second order in micrometres.

use nalgebra::{Cholesky, DMatrix, DVector};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;

use crate::diagnosis::linear::design_matrix::DesignMatrix;
use crate::diagnosis::linear::model::Model;
use crate::identification::ErrorSummary;
use crate::measurement::RowKind;

/// Folds.
const FOLDS: usize = 5;

/// Samples of each fold, random or in blocks.
pub(crate) fn folds(kept: &[usize], seed: Option<u64>) -> Vec<Vec<usize>> {
    let mut order = kept.to_vec();
    match seed {
        Some(seed) => {
            order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
            (0..FOLDS).map(|f| order.iter().copied().skip(f).step_by(FOLDS).collect()).collect()
        }
        None => order.chunks(kept.len().div_ceil(FOLDS).max(1)).map(<[usize]>::to_vec).collect(),
    }
}

/// Held-out errors of a model; `None` for a fold without which the rest decides nothing.
pub(crate) fn held_out(model: &Model, folds: &[Vec<usize>]) -> Option<ErrorSummary> {
    let mut squares = Squares::default();
    let table = model.table();
    for fold in folds {
        let rows: Vec<(usize, usize)> = fold.iter().map(|k| table.rows[*k]).collect();
        let (first, n) = *rows.first()?;
        let z = model.leverage(first, n).nrows();
        let count = rows.iter().map(|(_, n)| n).sum();
        let mut q_t = DMatrix::zeros(z, count);
        let mut r = DVector::zeros(count);
        let mut at = 0;
        for (first, n) in &rows {
            q_t.columns_mut(at, *n).copy_from(&model.leverage(*first, *n));
            r.rows_mut(at, *n).copy_from(&model.residual.rows(*first, *n));
            at += n;
        }
        let inner = DMatrix::identity(z, z) - &q_t * q_t.transpose();
        let factor = Cholesky::new(inner).filter(|f| f.l_dirty().diagonal().min() > 1e-5)?;
        let predicted = &r + q_t.tr_mul(&factor.solve(&(&q_t * &r)));
        let mut at = 0;
        for k in fold {
            let n = table.rows[*k].1;
            squares.add(table, *k, &predicted.rows(at, n).into_owned());
            at += n;
        }
    }
    Some(squares.summary())
}

/// RMS residual over samples.
pub(crate) fn rms(table: &DesignMatrix, residual: &DVector<f64>, kept: &[usize]) -> ErrorSummary {
    let mut squares = Squares::default();
    for k in kept {
        let (first, n) = table.rows[*k];
        squares.add(table, *k, &residual.rows(first, n).into_owned());
    }
    squares.summary()
}

/// Sums of squares over samples of the lengths of position and rotation errors.
#[derive(Default)]
struct Squares {
    position: (f64, usize),
    rotation: (f64, usize),
}

impl Squares {
    fn add(&mut self, table: &DesignMatrix, sample: usize, white: &DVector<f64>) {
        let first = table.rows[sample].0;
        let error = &table.unwhiten[sample] * white;
        for (kind, sum) in [(RowKind::Position, &mut self.position), (RowKind::Rotation, &mut self.rotation)] {
            let of_kind = error.iter().enumerate().filter(|(i, _)| table.kinds[first + i] == kind);
            let (total, count) = of_kind.fold((0.0, 0), |(s, c), (_, e)| (s + e * e, c + 1));
            if count > 0 {
                // Several targets count by their mean.
                *sum = (sum.0 + total / (count / 3).max(1) as f64, sum.1 + 1);
            }
        }
    }

    fn summary(&self) -> ErrorSummary {
        let root = |(sum, count): (f64, usize)| (count > 0).then(|| (sum / count as f64).sqrt());
        ErrorSummary { position: root(self.position), rotation: root(self.rotation) }
    }
}
