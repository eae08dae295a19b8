//! Batches of any mechanism: blocks of six white rows in full, `P = I`.

use nalgebra::DMatrix;
use pulp::Simd;

use super::Layout;
use super::lanes::{Lanes, Sym, Two, at, load, load_two};

/// The batches: entry (r, d) of a block in row `6 d + r`.
#[derive(Clone, Debug)]
pub(in super::super) struct Dense {
    pub(in super::super) data: Vec<Lanes>,
    pub(in super::super) parameters: usize,
}

impl Layout for Dense {
    fn rows(&self) -> usize {
        6 * self.parameters
    }

    fn parameters(&self) -> usize {
        self.parameters
    }

    fn batches(&self) -> &[Lanes] {
        &self.data
    }

    fn pack(&self, a: &DMatrix<f64>) -> Vec<f64> {
        a.as_slice().to_vec()
    }

    #[inline(always)]
    fn quadratic<S: Simd>(&self, simd: S, batch: &[Lanes], vector: usize, packed: &[f64]) -> Sym<Two<S>> {
        let zero = simd.splat_f64s(0.0);
        let mut out = [[zero; 2]; 21];
        let blocks = batch.as_chunks::<6>().0;
        for (column, own) in packed.chunks_exact(self.parameters).zip(blocks) {
            let mut t = [[zero; 2]; 6];
            for (a, block) in column.iter().zip(blocks) {
                let a = simd.splat_f64s(*a);
                for (sum, row) in t.iter_mut().zip(block) {
                    let b = load_two::<S>(row, vector);
                    *sum = [simd.mul_add_e_f64s(a, b[0], sum[0]), simd.mul_add_e_f64s(a, b[1], sum[1])];
                }
            }
            for i in 0..6 {
                for j in 0..=i {
                    let b = load_two::<S>(&own[j], vector);
                    let sum = &mut out[at(i, j)];
                    *sum = [simd.mul_add_e_f64s(t[i][0], b[0], sum[0]), simd.mul_add_e_f64s(t[i][1], b[1], sum[1])];
                }
            }
        }
        out
    }

    #[inline(always)]
    fn noise<S: Simd>(&self, simd: S, _batch: &[Lanes], _vector: usize) -> Sym<S::f64s> {
        let mut p = [simd.splat_f64s(0.0); 21];
        for i in 0..6 {
            p[at(i, i)] = simd.splat_f64s(1.0);
        }
        p
    }

    #[inline(always)]
    fn rotate<S: Simd>(&self, simd: S, batch: &[Lanes], vector: usize, q: &[f64], y: &mut Vec<S::f64s>) {
        y.clear();
        let blocks = batch.as_chunks::<6>().0;
        for column in q.chunks_exact(self.parameters) {
            let mut sums = [simd.splat_f64s(0.0); 6];
            for (factor, block) in column.iter().zip(blocks) {
                let factor = simd.splat_f64s(*factor);
                for (sum, row) in sums.iter_mut().zip(block) {
                    *sum = simd.mul_add_e_f64s(factor, load::<S>(row, vector), *sum);
                }
            }
            y.extend_from_slice(&sums);
        }
    }
}
