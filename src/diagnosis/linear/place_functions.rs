//! Functions of the sample at one place, for the tests that know no cause.

use nalgebra::{DMatrix, DVector};

use crate::diagnosis::linear::score_test::{ABSORBED, PLAINLY_SEEN, ScoreTest};

/// A unit displacement of one place in each sample by itself, projected.
#[derive(Debug)]
pub(crate) struct PlaceSamples {
    /// `Qᵀ` times the displacement (z × samples).
    pub(crate) w: DMatrix<f64>,
    /// Length squared of the displacement in each sample.
    pub(crate) square: DVector<f64>,
    /// Its product with the residual.
    pub(crate) along: DVector<f64>,
    /// As in the model.
    pub(crate) inflation: f64,
}

/// Sums over samples of pairs of functions at a place.
#[derive(Debug)]
pub(crate) struct PairSums {
    /// `Qᵀ` times the functions (z × 2 pairs).
    w: DMatrix<f64>,
    /// For the functions `f` and `g` of each pair: `f²`, `f g`, `g²`, and the products of `f` and `g` with the residual.
    sums: Vec<[f64; 5]>,
}

impl PlaceSamples {
    /// Functions of the sample (samples × columns) at this place: each `width` of them as one block.
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

    /// No samples yet of so many pairs of functions.
    pub(crate) fn pairs(&self, count: usize) -> PairSums {
        PairSums { w: DMatrix::zeros(self.w.nrows(), 2 * count), sums: vec![[0.0; 5]; count] }
    }

    /// Adds some samples (from `sample` on) of some pairs (from `pair` on): functions (samples × 2 pairs).
    pub(crate) fn add(&self, sums: &mut PairSums, sample: usize, pair: usize, functions: &DMatrix<f64>) {
        let (samples, columns) = functions.shape();
        sums.w.columns_mut(2 * pair, columns).gemm(1.0, &self.w.columns(sample, samples), functions, 1.0);
        let (square, along) = (self.square.rows(sample, samples), self.along.rows(sample, samples));
        let mut weighted = DVector::zeros(samples);
        for (k, sum) in sums.sums[pair..pair + columns / 2].iter_mut().enumerate() {
            let (f, g) = (functions.column(2 * k), functions.column(2 * k + 1));
            weighted.zip_zip_apply(&f, &square, |to, f, s| *to = f * s);
            sum[0] += weighted.dot(&f);
            sum[1] += weighted.dot(&g);
            weighted.zip_zip_apply(&g, &square, |to, g, s| *to = g * s);
            sum[2] += weighted.dot(&g);
            sum[3] += f.dot(&along);
            sum[4] += g.dot(&along);
        }
    }

    /// What each pair would gain, and how many directions of it are seen; as by [`ask`](Self::ask), without its matrices.
    pub(crate) fn gains_of_pairs(&self, all: &PairSums) -> Vec<(f64, usize)> {
        let pair = |(k, [ff, fg, gg, c, d]): (usize, &[f64; 5])| {
            let (wf, wg) = (all.w.column(2 * k), all.w.column(2 * k + 1));
            let (s, t, u) = (ff - wf.dot(&wf), fg - wf.dot(&wg), gg - wg.dot(&wg));
            let rest = u - t * t / s;
            // The determinant of the projected columns over their lengths before.
            if s > 0.0 && s * rest > PLAINLY_SEEN * ff * gg {
                return ((c * c / s + (d - c * t / s).powi(2) / rest) / self.inflation, 2);
            }
            let matrix = |a: f64, b: f64, c: f64| DMatrix::from_row_slice(2, 2, &[a, b, b, c]);
            let c = DVector::from_column_slice(&[*c, *d]);
            ScoreTest::of(&matrix(*ff, *fg, *gg), &matrix(s, t, u), &c, self.inflation).gain()
        };
        all.sums.iter().enumerate().map(pair).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_gain_what_the_general_question_says() {
        let samples = 40;
        let along = DVector::from_fn(samples, |k, _| ((7 * k) % 11) as f64 - 5.0);
        let square = DVector::from_fn(samples, |k, _| 1.0 + (k % 3) as f64);
        let w = DMatrix::from_fn(2, samples, |i, k| if k % (i + 2) == 0 { 0.2 } else { -0.1 });
        let asked = PlaceSamples { w, square, along, inflation: 1.3 };
        let mut functions = DMatrix::from_fn(samples, 6, |i, k| ((5 * i + 3 * k * k + i * k) % 13) as f64 - 6.0);
        // A pair that is one direction.
        let twice = functions.column(4) * 2.0;
        functions.set_column(5, &twice);
        let mut sums = asked.pairs(3);
        for (sample, some) in [(0, 25), (25, 15)] {
            for (pair, few) in [(0, 2), (2, 1)] {
                let part = functions.view((sample, 2 * pair), (some, 2 * few)).into_owned();
                asked.add(&mut sums, sample, pair, &part);
            }
        }
        for ((gain, rank), other) in asked.gains_of_pairs(&sums).into_iter().zip(asked.ask(&functions, 2)) {
            let (wanted, of) = other.gain();
            assert_eq!(rank, of);
            assert!((gain - wanted).abs() < 1e-10 * wanted, "{gain} {wanted}");
        }
    }
}
