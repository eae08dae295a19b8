//! Functions of the sample on one joint, for the tests that know no cause.

use nalgebra::{DMatrix, DVector};

use crate::diagnosis::linear::score_test::{ABSORBED, ScoreTest};

/// Functions of the sample on one joint, projected.
#[derive(Debug)]
pub(crate) struct JointFunctions {
    /// `Qᵀ` times the columns.
    pub(crate) w: DMatrix<f64>,
    /// Length squared of the unit displacement in each sample.
    pub(crate) square: DVector<f64>,
    /// Its product with the residual.
    pub(crate) along: DVector<f64>,
    /// The functions (samples × columns).
    pub(crate) functions: DMatrix<f64>,
    /// As in the model.
    pub(crate) inflation: f64,
}

impl JointFunctions {
    /// The block of some of the functions.
    pub(crate) fn ask(&self, columns: std::ops::Range<usize>) -> ScoreTest {
        let f = self.functions.columns(columns.start, columns.len());
        let w = self.w.columns(columns.start, columns.len());
        let weighted = DMatrix::from_fn(f.nrows(), f.ncols(), |i, k| f[(i, k)] * self.square[i]);
        let square = f.tr_mul(&weighted);
        ScoreTest::of(&square, &(&square - w.tr_mul(&w)), &f.tr_mul(&self.along), self.inflation)
    }

    /// For functions that are one on a single sample each: what their sum from each place of an order to its end would
    /// gain, where it is seen.
    pub(crate) fn gains_from(&self, order: &[usize]) -> Vec<Option<f64>> {
        let mut w = DVector::zeros(self.w.nrows());
        let (mut square, mut c) = (0.0, 0.0);
        let mut all = Vec::with_capacity(order.len());
        for k in order.iter().rev() {
            w += self.w.column(*k);
            square += self.square[*k];
            c += self.along[*k];
            let s: f64 = square - w.norm_squared();
            all.push((s > ABSORBED * square).then(|| c * c / (s * self.inflation)));
        }
        all.reverse();
        all
    }
}
