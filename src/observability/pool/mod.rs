//! The blocks of all candidates, in the layout that the scans read.

mod structure;

use nalgebra::{Cholesky, DMatrix, Matrix6, Matrix6xX};
use rayon::prelude::*;

use super::kernel::{Dense, LANES, Lanes, Legs, PER_LEG, SLOTS, gradient};
use super::rows::{at_least_square, stacked};
use structure::{Groups, groups_of, row_scales, visible_directions};

/// The information from one pose, as a factored block `J = P^-½ U` with rows and columns scaled.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// `P` (6 × 6): covariance of the closure residual, `J₁ Σ_q J₁ᵀ + Jⱼ Σⱼ Jⱼᵀ`, or the identity if the rows of `U`
    /// are white.
    pub noise: Matrix6<f64>,
    /// `U` (6 × L): derivatives of the closure along the scaled parameters.
    pub derivatives: Matrix6xX<f64>,
}

impl Block {
    /// The rows themselves (6 × L), up to a rotation among them, which changes no singular value. `None` if the
    /// covariance is not positive definite or a number is not finite.
    pub fn rows(&self) -> Option<DMatrix<f64>> {
        let lower = Cholesky::new(self.noise)?.unpack();
        let rows = lower.solve_lower_triangular(&self.derivatives)?;
        rows.iter().all(|v| v.is_finite()).then(|| DMatrix::from_iterator(6, rows.ncols(), rows.iter().copied()))
    }
}

/// Blocks that are looked at to find structure and scales.
const LOOKED_AT: usize = 512;

/// The blocks of all candidates.
#[derive(Clone, Debug)]
pub struct Pool {
    len: usize,
    pub(super) layout: Stored,
    /// Orthonormal basis (L × L') of the directions that the candidates see.
    visible: DMatrix<f64>,
    /// `W` (L' × L'): a row is its stored coordinates times `W`. Stored columns have about unit length and little
    /// correlation, which keeps the scans accurate although `JᵀJ` is hardly invertible in small workspaces.
    pub(super) basis: DMatrix<f64>,
    /// `W⁻¹`.
    pub(super) inverse: DMatrix<f64>,
}

#[derive(Clone, Debug)]
pub(super) enum Stored {
    Legs(Legs),
    Dense(Dense),
}

impl Pool {
    /// Stores `len` blocks, computed in parallel. Six legs with seven parameters each are recognised by the pattern of
    /// zeros. `None` if there is no block or one of them has no rows.
    pub fn new(len: usize, block: impl Fn(usize) -> Block + Sync) -> Option<Self> {
        if len == 0 {
            return None;
        }
        let step = len.div_ceil(LOOKED_AT);
        let looked_at: Vec<Block> = (0..len).step_by(step).map(&block).collect();
        let visible = visible_directions(&looked_at)?;
        let parameters = visible.nrows();
        let all_visible = visible.ncols() == parameters;
        if all_visible
            && let Some(groups) = groups_of(&looked_at)
            && let Some(pool) = Self::of_legs(len, &block, &looked_at, groups, visible.clone())
        {
            return Some(pool);
        }
        Self::of_rows(len, &block, &looked_at, visible)
    }

    fn of_legs(
        len: usize,
        block: &(impl Fn(usize) -> Block + Sync),
        looked_at: &[Block],
        groups: Groups,
        visible: DMatrix<f64>,
    ) -> Option<Self> {
        let mut basis = DMatrix::zeros(SLOTS, SLOTS);
        let mut inverse = DMatrix::zeros(SLOTS, SLOTS);
        let mut inverses = Vec::with_capacity(6);
        for (leg, columns) in groups.iter().enumerate() {
            let scaled = looked_at.iter().map(|b| Some((b, row_scales(&b.noise)?))).collect::<Option<Vec<_>>>()?;
            let stack = DMatrix::from_fn(scaled.len(), PER_LEG, |k, p| {
                let (block, scales) = &scaled[k];
                block.derivatives[(leg, columns[p])] * scales[leg]
            });
            if stack.nrows() < PER_LEG {
                return None;
            }
            let r = stack.qr().r() / (scaled.len() as f64).sqrt();
            let own = r.clone().try_inverse().filter(|m| m.iter().all(|v| v.is_finite()))?;
            for p in 0..PER_LEG {
                for (q, column) in columns.iter().enumerate() {
                    basis[(PER_LEG * leg + p, *column)] = r[(p, q)];
                    inverse[(*column, PER_LEG * leg + p)] = own[(q, p)];
                }
            }
            inverses.push(own);
        }
        let batches = len.div_ceil(LANES);
        let mut data = vec![[0.0; LANES]; batches * Legs::ROWS];
        let fits = data.par_chunks_exact_mut(Legs::ROWS).enumerate().try_for_each(|(batch, rows)| {
            // The last batch is filled up with its last candidate; masks keep the copies out.
            for (lane, k) in (batch * LANES..).take(LANES).enumerate() {
                let block = block(k.min(len - 1));
                let scales = row_scales(&block.noise)?;
                for (leg, columns) in groups.iter().enumerate() {
                    let own: usize = columns.iter().filter(|c| block.derivatives[(leg, **c)] != 0.0).count();
                    let all = block.derivatives.row(leg).iter().filter(|v| **v != 0.0).count();
                    if own != all {
                        return None;
                    }
                    for p in 0..PER_LEG {
                        let sum: f64 = (0..PER_LEG)
                            .map(|q| block.derivatives[(leg, columns[q])] * scales[leg] * inverses[leg][(q, p)])
                            .sum();
                        rows[Legs::u_row(leg, p)][lane] = sum;
                    }
                    for other in 0..=leg {
                        rows[Legs::p_row(leg, other)][lane] = block.noise[(leg, other)] * scales[leg] * scales[other];
                    }
                }
            }
            Some(())
        });
        fits?;
        Some(Self { len, layout: Stored::Legs(Legs { data }), visible, basis, inverse })
    }

    fn of_rows(
        len: usize,
        block: &(impl Fn(usize) -> Block + Sync),
        looked_at: &[Block],
        visible: DMatrix<f64>,
    ) -> Option<Self> {
        let parameters = visible.ncols();
        let blocks = looked_at.iter().map(|b| Some(b.rows()? * &visible)).collect::<Option<Vec<_>>>()?;
        let basis = at_least_square(stacked(&blocks, parameters, false)).qr().r() / (looked_at.len() as f64).sqrt();
        let inverse = basis.clone().try_inverse().filter(|m| m.iter().all(|v| v.is_finite()))?;
        let onto = &visible * &inverse;
        let batches = len.div_ceil(LANES);
        let mut data = vec![[0.0; LANES]; batches * 6 * parameters];
        let done = data.par_chunks_exact_mut(6 * parameters).enumerate().try_for_each(|(batch, rows)| {
            for lane in 0..LANES {
                let stored = block((batch * LANES + lane).min(len - 1)).rows()? * &onto;
                for (row, value) in rows.iter_mut().zip(stored.iter()) {
                    row[lane] = *value;
                }
            }
            Some(())
        });
        done?;
        Some(Self { len, layout: Stored::Dense(Dense { data, parameters }), visible, basis, inverse })
    }

    /// Number of candidates.
    pub fn len(&self) -> usize {
        self.len
    }

    /// True if there is none; [`new`](Self::new) makes no such pool.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Number `L'` of parameter directions that the candidates see.
    pub fn directions(&self) -> usize {
        self.visible.ncols()
    }

    /// Orthonormal basis (L × L') of these directions, in scaled parameters.
    pub fn visible(&self) -> &DMatrix<f64> {
        &self.visible
    }

    /// True if the blocks are stored by leg.
    pub fn has_legs(&self) -> bool {
        matches!(self.layout, Stored::Legs(..))
    }

    /// Rows (6 × L') of candidate `k` along the visible directions, up to a rotation among them.
    pub fn rows(&self, k: usize) -> DMatrix<f64> {
        self.stored(k) * &self.basis
    }

    /// `W` (L' × L'): rows along the visible directions are rows in stored coordinates times `W`.
    pub(crate) fn basis(&self) -> &DMatrix<f64> {
        &self.basis
    }

    /// `W⁻¹`.
    pub(crate) fn inverse_basis(&self) -> &DMatrix<f64> {
        &self.inverse
    }

    /// `ln |det W|`.
    pub(crate) fn log_volume(&self) -> f64 {
        self.basis.clone().lu().u().diagonal().iter().map(|v| v.abs().ln()).sum()
    }

    /// `tr(Φ JᵀJ)` of every candidate, for `Φ` in stored coordinates.
    pub(crate) fn directional(&self, phi: &DMatrix<f64>) -> Vec<f64> {
        let batches = self.len.div_ceil(LANES);
        let open = vec![[1.0; LANES]; batches];
        let mut out = vec![[0.0; LANES]; batches];
        match &self.layout {
            Stored::Legs(legs) => gradient(legs, phi, &open, &mut out),
            Stored::Dense(dense) => gradient(dense, phi, &open, &mut out),
        }
        out.into_iter().flatten().take(self.len).collect()
    }

    /// Rows of candidate `k` in stored coordinates.
    pub(crate) fn stored(&self, k: usize) -> DMatrix<f64> {
        let (batch, lane) = (k / LANES, k % LANES);
        match &self.layout {
            Stored::Legs(legs) => {
                let rows = &legs.data[batch * Legs::ROWS..(batch + 1) * Legs::ROWS];
                let mut u = DMatrix::zeros(6, SLOTS);
                let mut p = Matrix6::zeros();
                for leg in 0..6 {
                    for slot in 0..PER_LEG {
                        u[(leg, PER_LEG * leg + slot)] = rows[Legs::u_row(leg, slot)][lane];
                    }
                    for other in 0..=leg {
                        p[(leg, other)] = rows[Legs::p_row(leg, other)][lane];
                        p[(other, leg)] = p[(leg, other)];
                    }
                }
                // Every stored block passed this decomposition when it was made.
                let lower = Cholesky::new(p).map_or_else(Matrix6::identity, |c| c.unpack());
                lower.solve_lower_triangular_mut(&mut u);
                u
            }
            Stored::Dense(dense) => {
                let rows = 6 * dense.parameters;
                let batch = &dense.data[batch * rows..(batch + 1) * rows];
                DMatrix::from_fn(6, dense.parameters, |r, d| batch[6 * d + r][lane])
            }
        }
    }

    /// Some of the candidates in the same layout.
    pub(super) fn gather(&self, members: &[usize]) -> Stored {
        let rows = self.lane_rows();
        let from = self.lanes();
        let mut data = vec![[0.0; LANES]; members.len().div_ceil(LANES).max(1) * rows];
        for slot in 0..data.len() / rows * LANES {
            let Some(k) = members.get(slot).or(members.last()) else { continue };
            let (source, target) = (k / LANES * rows, slot / LANES * rows);
            for row in 0..rows {
                data[target + row][slot % LANES] = from[source + row][k % LANES];
            }
        }
        match &self.layout {
            Stored::Legs(_) => Stored::Legs(Legs { data }),
            Stored::Dense(dense) => Stored::Dense(Dense { data, parameters: dense.parameters }),
        }
    }

    fn lane_rows(&self) -> usize {
        match &self.layout {
            Stored::Legs(..) => Legs::ROWS,
            Stored::Dense(dense) => 6 * dense.parameters,
        }
    }

    fn lanes(&self) -> &[Lanes] {
        match &self.layout {
            Stored::Legs(legs) => &legs.data,
            Stored::Dense(dense) => &dense.data,
        }
    }
}
