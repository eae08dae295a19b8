//! Batches of a mechanism of six legs with seven parameters each.
//!
//! `S_ij = uᵢᵀ A_ij uⱼ`, with the 7 × 7 blocks of `A`: a tenth of the arithmetic of a dense block. The rows of a leg
//! stand next to those of `P` that belong to it, so that a scan reads memory from front to back. Rows of `U` and `P`
//! are scaled so that `P` has equal diagonal entries and `det P = 1`, which changes no score.

use nalgebra::{DMatrix, Matrix6};
use pulp::Simd;

use super::Layout;
use super::lanes::{LANES, Lanes, Sym, Two, at, load, load_two};
use super::update::LegBlock;

/// Parameters of a leg.
pub(in super::super) const PER_LEG: usize = 7;
const LEGS: usize = 6;
/// Parameters of all legs.
pub(in super::super) const SLOTS: usize = LEGS * PER_LEG;
/// Rows of lanes: `u` and the lower triangle of `P`.
const ROWS: usize = SLOTS + 21;
/// Entries of a block of `A`.
const BLOCK: usize = PER_LEG * PER_LEG;

/// First row of a leg: its seven `u`, then row `leg` of `P` up to the diagonal.
const fn first(leg: usize) -> usize {
    PER_LEG * leg + at(leg, 0)
}

/// The batches.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Legs {
    pub(in super::super) data: Vec<Lanes>,
}

impl Legs {
    pub(in super::super) const ROWS: usize = ROWS;

    /// Row of lanes of parameter `p` of a leg.
    pub(in super::super) const fn u_row(leg: usize, p: usize) -> usize {
        first(leg) + p
    }

    /// Row of lanes of entry (i, j), `j ≤ i`, of `P`.
    pub(in super::super) const fn p_row(i: usize, j: usize) -> usize {
        first(i) + PER_LEG + j
    }

    /// The block of candidate `k`.
    pub(in super::super) fn block(&self, k: usize) -> LegBlock {
        let (batch, lane) = (k / LANES, k % LANES);
        let rows = &self.data[batch * ROWS..(batch + 1) * ROWS];
        let u = std::array::from_fn(|leg| std::array::from_fn(|p| rows[Self::u_row(leg, p)][lane]));
        LegBlock { u, p: Matrix6::from_fn(|i, j| rows[Self::p_row(i.max(j), i.min(j))][lane]) }
    }
}

impl Layout for Legs {
    fn rows(&self) -> usize {
        ROWS
    }

    fn parameters(&self) -> usize {
        SLOTS
    }

    fn batches(&self) -> &[Lanes] {
        &self.data
    }

    /// Blocks (i, j) for `j = 0..6`, `i ≤ j`, row-major. Of a diagonal block the upper triangle, doubled off the
    /// diagonal: the other half of the sum.
    fn pack(&self, a: &DMatrix<f64>) -> Vec<f64> {
        let mut packed = vec![0.0; 21 * BLOCK];
        let mut blocks = packed.as_chunks_mut::<BLOCK>().0.iter_mut();
        let (columns, _) = a.as_slice().as_chunks::<SLOTS>();
        for (j, columns) in columns.chunks_exact(PER_LEG).enumerate() {
            for i in 0..=j {
                let Some(block) = blocks.next() else { return packed };
                for (q, column) in columns.iter().enumerate() {
                    for p in 0..PER_LEG {
                        let value = column[PER_LEG * i + p];
                        block[PER_LEG * p + q] = if i < j || p == q { value } else { 2.0 * value };
                    }
                }
            }
        }
        packed
    }

    #[inline(always)]
    fn quadratic<S: Simd>(&self, simd: S, batch: &[Lanes], vector: usize, packed: &[f64]) -> Sym<Two<S>> {
        let zero = simd.splat_f64s(0.0);
        let mut out = [[zero; 2]; 21];
        let mut blocks = packed.as_chunks::<BLOCK>().0.iter();
        for j in 0..LEGS {
            // Not `array::from_fn`: a closure is compiled for the least machine and called.
            let mut uj = [[zero; 2]; PER_LEG];
            for (u, row) in uj.iter_mut().zip(block_rows(batch, j)) {
                *u = load_two::<S>(row, vector);
            }
            for i in 0..j {
                let Some(block) = blocks.next() else { return out };
                let rows: &[Lanes; PER_LEG] = block_rows(batch, i);
                let mut sum = [zero; 2];
                for p in 0..PER_LEG {
                    let a = simd.splat_f64s(block[PER_LEG * p]);
                    let mut t = [simd.mul_f64s(a, uj[0][0]), simd.mul_f64s(a, uj[0][1])];
                    for q in 1..PER_LEG {
                        let a = simd.splat_f64s(block[PER_LEG * p + q]);
                        t[0] = simd.mul_add_e_f64s(a, uj[q][0], t[0]);
                        t[1] = simd.mul_add_e_f64s(a, uj[q][1], t[1]);
                    }
                    let ui = load_two::<S>(&rows[p], vector);
                    sum[0] = simd.mul_add_e_f64s(ui[0], t[0], sum[0]);
                    sum[1] = simd.mul_add_e_f64s(ui[1], t[1], sum[1]);
                }
                out[at(j, i)] = sum;
            }
            let Some(block) = blocks.next() else { return out };
            let mut sum = [zero; 2];
            for p in 0..PER_LEG {
                let a = simd.splat_f64s(block[(PER_LEG + 1) * p]);
                let mut t = [simd.mul_f64s(a, uj[p][0]), simd.mul_f64s(a, uj[p][1])];
                for q in p + 1..PER_LEG {
                    let a = simd.splat_f64s(block[PER_LEG * p + q]);
                    t[0] = simd.mul_add_e_f64s(a, uj[q][0], t[0]);
                    t[1] = simd.mul_add_e_f64s(a, uj[q][1], t[1]);
                }
                sum[0] = simd.mul_add_e_f64s(uj[p][0], t[0], sum[0]);
                sum[1] = simd.mul_add_e_f64s(uj[p][1], t[1], sum[1]);
            }
            out[at(j, j)] = sum;
        }
        out
    }

    #[inline(always)]
    fn noise<S: Simd>(&self, simd: S, batch: &[Lanes], vector: usize) -> Sym<S::f64s> {
        let mut p = [simd.splat_f64s(0.0); 21];
        for i in 0..LEGS {
            for j in 0..=i {
                p[at(i, j)] = load::<S>(&batch[Legs::p_row(i, j)], vector);
            }
        }
        p
    }

    #[inline(always)]
    fn rotate<S: Simd>(&self, simd: S, batch: &[Lanes], vector: usize, q: &[f64], y: &mut Vec<S::f64s>) {
        y.clear();
        for column in q.as_chunks::<SLOTS>().0 {
            for leg in 0..LEGS {
                let rows = block_rows(batch, leg);
                let mut sum = simd.mul_f64s(simd.splat_f64s(column[PER_LEG * leg]), load::<S>(&rows[0], vector));
                for p in 1..PER_LEG {
                    let factor = simd.splat_f64s(column[PER_LEG * leg + p]);
                    sum = simd.mul_add_e_f64s(factor, load::<S>(&rows[p], vector), sum);
                }
                y.push(sum);
            }
        }
    }
}

/// The seven rows of a leg.
#[inline(always)]
fn block_rows(batch: &[Lanes], leg: usize) -> &[Lanes; PER_LEG] {
    const EMPTY: [Lanes; PER_LEG] = [[0.0; super::LANES]; PER_LEG];
    // A batch has all rows; the empty ones stand where the type asks for something.
    batch[first(leg)..].first_chunk().unwrap_or(&EMPTY)
}
