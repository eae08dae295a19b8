//! Functions of the sample on one joint, for the tests that know no cause.

use nalgebra::{DMatrix, DVector};

use crate::diagnosis::linear::score_test::{ABSORBED, ScoreTest};

/// A unit displacement of one joint in each sample by itself, projected.
#[derive(Debug)]
pub(crate) struct JointSamples {
    /// `Qᵀ` times the displacement (z × samples).
    pub(crate) w: DMatrix<f64>,
    /// Length squared of the displacement in each sample.
    pub(crate) square: DVector<f64>,
    /// Its product with the residual.
    pub(crate) along: DVector<f64>,
    /// As in the model.
    pub(crate) inflation: f64,
}

impl JointSamples {
    /// Functions of the sample (samples × columns) on this joint: each `width` of them as one block.
    pub(crate) fn ask(&self, functions: &DMatrix<f64>, width: usize) -> Vec<ScoreTest> {
        let w = &self.w * functions;
        let mut weighted = DVector::zeros(functions.nrows());
        let block = |first: usize| {
            let (f, w) = (functions.columns(first, width), w.columns(first, width));
            let mut square = DMatrix::zeros(width, width);
            for k in 0..width {
                weighted.copy_from(&f.column(k));
                weighted.component_mul_assign(&self.square);
                for i in 0..=k {
                    let product = f.column(i).dot(&weighted);
                    (square[(i, k)], square[(k, i)]) = (product, product);
                }
            }
            ScoreTest::of(&square, &(&square - w.tr_mul(&w)), &f.tr_mul(&self.along), self.inflation)
        };
        (0..functions.ncols()).step_by(width).map(block).collect()
    }

    /// What the sum of the displacements from each place of an order to its end would gain, where it is seen.
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
