//! The blocks of all candidates, in the layout that the scans read.

mod build;
mod raw;
mod structure;

use nalgebra::{Cholesky, DMatrix, Matrix6, Matrix6xX};
use rayon::prelude::*;

use super::kernel::{Dense, LANES, Lanes, LegBlock, Legs, PER_LEG, SLOTS, gradient, update_legs};
use super::rows::update_inverse;
use raw::alike;
use structure::Groups;

pub(crate) use build::PoolBuilder;

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

/// The blocks of all candidates.
#[derive(Clone, Debug)]
pub struct Pool {
    len: usize,
    pub(super) layout: Stored,
    pub(super) coordinates: Coordinates,
}

#[derive(Clone, Debug)]
pub(super) enum Stored {
    Legs(Legs),
    Dense(Dense),
}

/// The coordinates in which blocks are stored.
#[derive(Clone, Debug)]
pub(super) struct Coordinates {
    /// Orthonormal basis (L × L') of the directions that the candidates see.
    visible: DMatrix<f64>,
    /// `W` (L' × L'): a row is its stored coordinates times `W`. Stored columns have about unit length and little
    /// correlation, which keeps the scans accurate although `JᵀJ` is hardly invertible in small workspaces.
    pub(super) basis: DMatrix<f64>,
    /// `W⁻¹`.
    pub(super) inverse: DMatrix<f64>,
    /// Parameters of each leg if blocks are stored by leg.
    groups: Option<Groups>,
}

/// Blocks that are computed in parallel before they are stored.
const AT_ONCE: usize = 4096;

impl Pool {
    /// Stores `len` blocks, computed in parallel, each once. Six legs with seven parameters each are recognised by the
    /// pattern of zeros. `None` if there is no block or one of them has no rows.
    pub fn new(len: usize, block: impl Fn(usize) -> Block + Sync) -> Option<Self> {
        let mut builder = PoolBuilder::new(len);
        for first in (0..len).step_by(AT_ONCE) {
            let blocks: Vec<Block> = (first..len.min(first + AT_ONCE)).into_par_iter().map(&block).collect();
            blocks.into_iter().for_each(|block| builder.push(block));
        }
        builder.finish()
    }

    /// Further blocks in the coordinates of this pool, as far as they lie along its visible directions. `None` if there
    /// is none, or if they cannot be stored in the same layout.
    pub(crate) fn alike(&self, blocks: &[Block]) -> Option<Self> {
        let layout = alike(&self.coordinates, blocks)?;
        Some(Self { len: blocks.len(), layout, coordinates: self.coordinates.clone() })
    }

    /// Some of the candidates, as a pool of their own in the same coordinates.
    pub(crate) fn only(&self, members: &[usize]) -> Self {
        Self { len: members.len(), layout: gathered(&[self], members), coordinates: self.coordinates.clone() }
    }

    /// Some of the candidates of this pool and of another in its coordinates, whose candidates are numbered behind
    /// those of this one.
    pub(crate) fn joined(&self, other: &Self, members: &[usize]) -> Self {
        let layout = gathered(&[self, other], members);
        Self { len: members.len(), layout, coordinates: self.coordinates.clone() }
    }

    /// Some of the candidates in the same layout.
    pub(super) fn gather(&self, members: &[usize]) -> Stored {
        gathered(&[self], members)
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
        self.coordinates.visible.ncols()
    }

    /// Orthonormal basis (L × L') of these directions, in scaled parameters.
    pub fn visible(&self) -> &DMatrix<f64> {
        &self.coordinates.visible
    }

    /// True if the blocks are stored by leg.
    pub fn has_legs(&self) -> bool {
        matches!(self.layout, Stored::Legs(..))
    }

    /// Rows (6 × L') of candidate `k` along the visible directions, up to a rotation among them.
    pub fn rows(&self, k: usize) -> DMatrix<f64> {
        self.stored(k) * &self.coordinates.basis
    }

    /// `W` (L' × L'): rows along the visible directions are rows in stored coordinates times `W`.
    pub(crate) fn basis(&self) -> &DMatrix<f64> {
        &self.coordinates.basis
    }

    /// `W⁻¹`.
    pub(crate) fn inverse_basis(&self) -> &DMatrix<f64> {
        &self.coordinates.inverse
    }

    /// `ln |det W|`.
    pub(crate) fn log_volume(&self) -> f64 {
        self.coordinates.basis.clone().lu().u().diagonal().iter().map(|v| v.abs().ln()).sum()
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

    /// Turns `M⁻¹` in stored coordinates into that with a candidate more (`sign = 1`) or less (`sign = -1`); the
    /// logarithm of the ratio of the determinants, or `None`, and nothing done, where that would be inaccurate.
    pub(super) fn update(&self, inverse: &mut DMatrix<f64>, k: usize, sign: f64, smallest_pivot: f64) -> Option<f64> {
        match &self.layout {
            Stored::Legs(legs) => update_legs(inverse, &legs.block(k), sign, smallest_pivot),
            Stored::Dense(_) => update_inverse(inverse, &self.stored(k), sign, smallest_pivot),
        }
    }

    /// Rows of candidate `k` in stored coordinates.
    pub(crate) fn stored(&self, k: usize) -> DMatrix<f64> {
        match &self.layout {
            Stored::Legs(legs) => {
                let LegBlock { u: own, p } = legs.block(k);
                let mut u = DMatrix::zeros(6, SLOTS);
                for (leg, own) in own.iter().enumerate() {
                    for (slot, value) in own.iter().enumerate() {
                        u[(leg, PER_LEG * leg + slot)] = *value;
                    }
                }
                // Every stored block passed this decomposition when it was made.
                let lower = Cholesky::new(p).map_or_else(Matrix6::identity, |c| c.unpack());
                lower.solve_lower_triangular_mut(&mut u);
                u
            }
            Stored::Dense(dense) => {
                let (batch, lane, rows) = (k / LANES, k % LANES, 6 * dense.parameters);
                let batch = &dense.data[batch * rows..(batch + 1) * rows];
                DMatrix::from_fn(6, dense.parameters, |r, d| batch[6 * d + r][lane])
            }
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

/// Some of the candidates of pools with the same coordinates, numbered one pool after the other.
fn gathered(pools: &[&Pool], members: &[usize]) -> Stored {
    let rows = pools[0].lane_rows();
    let mut data = vec![[0.0; LANES]; members.len().div_ceil(LANES).max(1) * rows];
    for slot in 0..data.len() / rows * LANES {
        // The last batch is filled up with its last candidate.
        let Some(mut k) = members.get(slot).or(members.last()).copied() else { continue };
        let mut pool = pools[0];
        for later in &pools[1..] {
            if k >= pool.len {
                k -= pool.len;
                pool = later;
            }
        }
        let (from, target) = (&pool.lanes()[k / LANES * rows..], slot / LANES * rows);
        for row in 0..rows {
            data[target + row][slot % LANES] = from[row][k % LANES];
        }
    }
    match &pools[0].layout {
        Stored::Legs(_) => Stored::Legs(Legs { data }),
        Stored::Dense(dense) => Stored::Dense(Dense { data, parameters: dense.parameters }),
    }
}
