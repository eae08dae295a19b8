//! Storing blocks that come one after another, each once and in the place that it keeps.
//!
//! The coordinates of a pool depend on all of its blocks, so that blocks are first stored as they are (rows scaled, see
//! [`row_scales`](super::structure::row_scales)) and moved to those coordinates in place when the last one has come: a million blocks never lie in
//! memory twice.

use nalgebra::DMatrix;

use super::raw::Raw;
use super::structure::visible_directions;
use super::{Block, Coordinates, Pool};
use crate::observability::kernel::LANES;
use crate::observability::rows::{at_least_square, stacked};

/// Blocks that are looked at to find the coordinates.
const LOOKED_AT: usize = 512;
/// Blocks that wait before they are stored, whole batches; the structure is sought among the first of them.
const WAITING: usize = 256 * LANES;

/// A pool in the making.
#[derive(Debug)]
pub(crate) struct PoolBuilder {
    expected: usize,
    waiting: Vec<Block>,
    /// Blocks stored; `None` in `stored` until the first are.
    len: usize,
    stored: Option<Raw>,
    /// True once a block had no rows: there is no pool then.
    failed: bool,
}

impl PoolBuilder {
    /// For about this many blocks.
    pub(crate) fn new(expected: usize) -> Self {
        let waiting = Vec::with_capacity(expected.min(WAITING));
        Self { expected, waiting, len: 0, stored: None, failed: false }
    }

    /// Takes the next block.
    pub(crate) fn push(&mut self, block: Block) {
        self.waiting.push(block);
        if self.waiting.len() == WAITING {
            self.store();
        }
    }

    fn store(&mut self) {
        let blocks = std::mem::take(&mut self.waiting);
        if blocks.is_empty() || self.failed {
            return;
        }
        let raw = self.stored.take().unwrap_or_else(|| Raw::for_blocks(&blocks, self.expected));
        self.stored = raw.extended(self.len, &blocks);
        self.failed = self.stored.is_none();
        self.len += blocks.len();
        self.waiting = blocks;
        self.waiting.clear();
    }

    /// The pool; `None` if there is no block or one of them has no rows.
    pub(crate) fn finish(mut self) -> Option<Pool> {
        self.store();
        let len = self.len;
        let mut raw = self.stored?;
        let sample: Vec<usize> = (0..len).step_by(len.div_ceil(LOOKED_AT)).collect();
        let rows = sample.iter().map(|k| raw.rows(*k)).collect::<Option<Vec<_>>>()?;
        let visible = visible_directions(&rows)?;
        let all_visible = visible.ncols() == visible.nrows();
        let of_legs = if all_visible { raw.leg_coordinates(&sample, &visible) } else { None };
        let coordinates = match of_legs {
            Some(coordinates) => coordinates,
            None => {
                raw = raw.into_rows(len)?;
                row_coordinates(&rows, visible)?
            }
        };
        Some(Pool { len, layout: raw.moved_to(&coordinates), coordinates })
    }
}

/// Coordinates in which rows along all visible directions have about unit length and little correlation.
fn row_coordinates(rows: &[DMatrix<f64>], visible: DMatrix<f64>) -> Option<Coordinates> {
    let seen: Vec<DMatrix<f64>> = rows.iter().map(|r| r * &visible).collect();
    let basis = at_least_square(stacked(&seen, visible.ncols(), false)).qr().r() / (rows.len() as f64).sqrt();
    let inverse = basis.clone().try_inverse().filter(|m| m.iter().all(|v| v.is_finite()))?;
    Some(Coordinates { visible, basis, inverse, groups: None })
}
