//! Blocks on their way into a pool: first as they are, then moved in place to its coordinates.

use nalgebra::{DMatrix, Matrix6, Matrix6xX};
use rayon::prelude::*;

use super::structure::{Groups, groups_of, row_scales};
use super::{Block, Coordinates, Stored};
use crate::observability::kernel::{Dense, LANES, Lanes, Legs, PER_LEG, SLOTS};

/// Blocks in batches, not yet in the coordinates of the pool.
#[derive(Debug)]
pub(super) enum Raw {
    /// Row `i` of `U` along the parameters of leg `i`, and `P`.
    Legs { groups: Box<Groups>, data: Vec<Lanes> },
    /// White rows in full, along scaled parameters.
    Rows { parameters: usize, data: Vec<Lanes> },
}

impl Raw {
    /// Empty, in the layout that suits the first blocks.
    pub(super) fn for_blocks(blocks: &[Block], expected: usize) -> Self {
        let parameters = blocks.first().map_or(0, |b| b.derivatives.ncols());
        let batches = expected.max(blocks.len()).div_ceil(LANES);
        match groups_of(blocks) {
            Some(groups) => Self::Legs { groups: Box::new(groups), data: Vec::with_capacity(batches * Legs::ROWS) },
            None => Self::Rows { parameters, data: Vec::with_capacity(batches * 6 * parameters) },
        }
    }

    /// With blocks behind the first `len`, which are whole batches. `None` if one of them has no rows.
    pub(super) fn extended(mut self, len: usize, blocks: &[Block]) -> Option<Self> {
        if self.append(blocks).is_some() {
            return Some(self);
        }
        // Blocks without the structure of those before them: all are then stored in full.
        let mut full = match self {
            Self::Legs { .. } => self.into_rows(len)?,
            Self::Rows { .. } => return None,
        };
        full.append(blocks)?;
        Some(full)
    }

    fn append(&mut self, blocks: &[Block]) -> Option<()> {
        match self {
            Self::Legs { groups, data } => {
                store(data, Legs::ROWS, blocks, |rows, lane, block| store_legs(rows, lane, block, groups))
            }
            Self::Rows { parameters, data } => {
                store(data, 6 * *parameters, blocks, |rows, lane, block| store_rows(rows, lane, &block.rows()?))
            }
        }
    }

    /// White rows (6 × L) of block `k` along the scaled parameters.
    pub(super) fn rows(&self, k: usize) -> Option<DMatrix<f64>> {
        let (batch, lane) = (k / LANES, k % LANES);
        match self {
            Self::Legs { groups, data } => {
                let rows = &data[batch * Legs::ROWS..(batch + 1) * Legs::ROWS];
                let (mut noise, mut derivatives) = (Matrix6::zeros(), Matrix6xX::zeros(SLOTS));
                for (leg, columns) in groups.iter().enumerate() {
                    for (p, column) in columns.iter().enumerate() {
                        derivatives[(leg, *column)] = rows[Legs::u_row(leg, p)][lane];
                    }
                    for other in 0..=leg {
                        noise[(leg, other)] = rows[Legs::p_row(leg, other)][lane];
                        noise[(other, leg)] = noise[(leg, other)];
                    }
                }
                Block { noise, derivatives }.rows()
            }
            Self::Rows { parameters, data } => {
                let rows = &data[batch * 6 * parameters..(batch + 1) * 6 * parameters];
                Some(DMatrix::from_fn(6, *parameters, |r, d| rows[6 * d + r][lane]))
            }
        }
    }

    /// The same blocks without use of a structure.
    pub(super) fn into_rows(self, len: usize) -> Option<Self> {
        let Self::Legs { .. } = &self else { return Some(self) };
        let rows = 6 * SLOTS;
        let mut data = vec![[0.0; LANES]; len.div_ceil(LANES) * rows];
        data.par_chunks_exact_mut(rows).enumerate().try_for_each(|(batch, rows)| {
            (0..LANES).try_for_each(|lane| store_rows(rows, lane, &self.rows((batch * LANES + lane).min(len - 1))?))
        })?;
        Some(Self::Rows { parameters: SLOTS, data })
    }

    /// Coordinates in which the seven parameters of each leg are white over a sample. `None` without legs, or if the
    /// sample does not determine them.
    pub(super) fn leg_coordinates(&self, sample: &[usize], visible: &DMatrix<f64>) -> Option<Coordinates> {
        let Self::Legs { groups, data } = self else { return None };
        if sample.len() < PER_LEG {
            return None;
        }
        let mut basis = DMatrix::zeros(SLOTS, SLOTS);
        let mut inverse = DMatrix::zeros(SLOTS, SLOTS);
        for (leg, columns) in groups.iter().enumerate() {
            let stack = DMatrix::from_fn(sample.len(), PER_LEG, |row, p| {
                let (batch, lane) = (sample[row] / LANES, sample[row] % LANES);
                data[batch * Legs::ROWS + Legs::u_row(leg, p)][lane]
            });
            let r = stack.qr().r() / (sample.len() as f64).sqrt();
            let own = r.clone().try_inverse().filter(|m| m.iter().all(|v| v.is_finite()))?;
            for p in 0..PER_LEG {
                for (q, column) in columns.iter().enumerate() {
                    basis[(PER_LEG * leg + p, *column)] = r[(p, q)];
                    inverse[(*column, PER_LEG * leg + p)] = own[(q, p)];
                }
            }
        }
        Some(Coordinates { visible: visible.clone(), basis, inverse, groups: Some(**groups) })
    }

    /// The blocks in the coordinates of a pool, where they lie if they have the room.
    pub(super) fn moved_to(self, coordinates: &Coordinates) -> Stored {
        match self {
            Self::Legs { groups, mut data } => {
                let own: [[[f64; PER_LEG]; PER_LEG]; 6] = std::array::from_fn(|leg| {
                    std::array::from_fn(|q| {
                        std::array::from_fn(|p| coordinates.inverse[(groups[leg][q], PER_LEG * leg + p)])
                    })
                });
                data.par_chunks_exact_mut(Legs::ROWS).for_each(|rows| turn_legs(rows, &own));
                Stored::Legs(Legs { data })
            }
            Self::Rows { parameters, mut data } => {
                let onto = &coordinates.visible * &coordinates.inverse;
                let directions = onto.ncols();
                if directions == parameters {
                    data.par_chunks_exact_mut(6 * parameters).for_each(|rows| {
                        let from = rows.to_vec();
                        turn_rows(&from, &onto, rows);
                    });
                } else {
                    let batches = data.len() / (6 * parameters);
                    let mut seen = vec![[0.0; LANES]; batches * 6 * directions];
                    let pairs = seen.par_chunks_exact_mut(6 * directions).zip(data.par_chunks_exact(6 * parameters));
                    pairs.for_each(|(rows, from)| turn_rows(from, &onto, rows));
                    data = seen;
                }
                Stored::Dense(Dense { data, parameters: directions })
            }
        }
    }
}

/// Blocks in the coordinates of a pool that exists. `None` if there is none, or if they have another structure.
pub(super) fn alike(coordinates: &Coordinates, blocks: &[Block]) -> Option<Stored> {
    let mut raw = match coordinates.groups {
        Some(groups) => Raw::Legs { groups: Box::new(groups), data: Vec::new() },
        None => Raw::Rows { parameters: coordinates.visible.nrows(), data: Vec::new() },
    };
    if blocks.is_empty() || blocks.iter().any(|b| b.derivatives.ncols() != coordinates.visible.nrows()) {
        return None;
    }
    raw.append(blocks)?;
    Some(raw.moved_to(coordinates))
}

/// Stores blocks behind those that there are, in parallel; nothing if one of them fails.
fn store(
    data: &mut Vec<Lanes>,
    rows: usize,
    blocks: &[Block],
    one: impl Fn(&mut [Lanes], usize, &Block) -> Option<()> + Sync,
) -> Option<()> {
    if rows == 0 {
        return None;
    }
    let before = data.len();
    data.resize(before + blocks.len().div_ceil(LANES) * rows, [0.0; LANES]);
    let batches = data[before..].par_chunks_exact_mut(rows).zip(blocks.par_chunks(LANES));
    // The last batch is filled up with its last block; masks keep the copies out.
    let done = batches
        .map(|(rows, blocks)| (0..LANES).try_for_each(|lane| one(rows, lane, blocks.get(lane).or(blocks.last())?)));
    let done: Option<()> = done.collect();
    if done.is_none() {
        data.truncate(before);
    }
    done
}

fn store_legs(rows: &mut [Lanes], lane: usize, block: &Block, groups: &Groups) -> Option<()> {
    let scales = row_scales(&block.noise)?;
    for (leg, columns) in groups.iter().enumerate() {
        let own = columns.iter().filter(|c| block.derivatives[(leg, **c)] != 0.0).count();
        let all = block.derivatives.row(leg).iter().filter(|v| **v != 0.0).count();
        if own != all {
            return None;
        }
        for (p, column) in columns.iter().enumerate() {
            rows[Legs::u_row(leg, p)][lane] = block.derivatives[(leg, *column)] * scales[leg];
        }
        for other in 0..=leg {
            rows[Legs::p_row(leg, other)][lane] = block.noise[(leg, other)] * scales[leg] * scales[other];
        }
    }
    Some(())
}

fn store_rows(target: &mut [Lanes], lane: usize, rows: &DMatrix<f64>) -> Option<()> {
    if rows.len() != target.len() {
        return None;
    }
    for (row, value) in target.iter_mut().zip(rows.iter()) {
        row[lane] = *value;
    }
    Some(())
}

/// Multiplies the seven numbers of each leg, as a row, by the inverse basis of the leg.
fn turn_legs(rows: &mut [Lanes], inverses: &[[[f64; PER_LEG]; PER_LEG]; 6]) {
    for (leg, inverse) in inverses.iter().enumerate() {
        let first = Legs::u_row(leg, 0);
        let from: [Lanes; PER_LEG] = std::array::from_fn(|q| rows[first + q]);
        for p in 0..PER_LEG {
            let mut sum = [0.0; LANES];
            for (from, inverse) in from.iter().zip(inverse) {
                for (sum, from) in sum.iter_mut().zip(from) {
                    *sum += from * inverse[p];
                }
            }
            rows[first + p] = sum;
        }
    }
}

fn turn_rows(from: &[Lanes], onto: &DMatrix<f64>, target: &mut [Lanes]) {
    for lane in 0..LANES {
        let rows = DMatrix::from_fn(6, onto.nrows(), |r, d| from[6 * d + r][lane]) * onto;
        for (row, value) in target.iter_mut().zip(rows.iter()) {
            row[lane] = *value;
        }
    }
}
