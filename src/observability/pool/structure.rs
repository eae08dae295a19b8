//! Common structure of the blocks of a mechanism: which rows involve which parameters, and which directions no row
//! determines.

use nalgebra::{Cholesky, DMatrix, Matrix6};

use super::Block;
use crate::observability::kernel::{PER_LEG, SLOTS};
use crate::observability::rows::{at_least_square, stacked};
use crate::solve::svd;

/// Directions seen by less than this part of the strongest are invisible.
const INVISIBLE: f64 = 1e-12;

/// Parameters that the closure row of each leg knows.
pub(super) type Groups = [[usize; PER_LEG]; 6];

/// Factors of the rows of `U` that give `P` equal diagonal entries and the determinant one.
pub(super) fn row_scales(noise: &Matrix6<f64>) -> Option<[f64; 6]> {
    let scales: [f64; 6] = std::array::from_fn(|i| 1.0 / noise[(i, i)].sqrt());
    let unit = Matrix6::from_fn(|i, j| noise[(i, j)] * scales[i] * scales[j]);
    let determinant = Cholesky::new(unit)?.determinant();
    let common = determinant.powf(-1.0 / 12.0);
    common.is_finite().then(|| scales.map(|s| s * common))
}

/// The parameters of each row, if six rows share all parameters among them, seven each.
pub(super) fn groups_of(blocks: &[Block]) -> Option<Groups> {
    let parameters = blocks.first()?.derivatives.ncols();
    if parameters != SLOTS {
        return None;
    }
    let mut groups: [Vec<usize>; 6] = Default::default();
    for column in 0..parameters {
        let known = |row: &usize| blocks.iter().any(|b| b.derivatives[(*row, column)] != 0.0);
        let mut rows = (0..6).filter(known);
        let (row, None) = (rows.next()?, rows.next()) else { return None };
        groups[row].push(column);
    }
    let mut out = [[0; PER_LEG]; 6];
    for (out, group) in out.iter_mut().zip(groups) {
        *out = group.try_into().ok()?;
    }
    Some(out)
}

/// Orthonormal basis of the row space of blocks of rows (6 × L); the identity if they see everything.
pub(super) fn visible_directions(blocks: &[DMatrix<f64>]) -> Option<DMatrix<f64>> {
    let parameters = blocks.first()?.ncols();
    let mut r = at_least_square(stacked(blocks, parameters, false)).qr().r();
    let lengths: Vec<f64> = r.column_iter().map(|c| c.norm()).collect();
    for (mut column, length) in r.column_iter_mut().zip(&lengths) {
        column.unscale_mut(if *length > 0.0 { *length } else { 1.0 });
    }
    let svd = svd(r, false, true);
    let v_t = svd.v_t?;
    let strongest = svd.singular_values.max();
    let seen: Vec<usize> = (0..parameters).filter(|k| svd.singular_values[*k] > INVISIBLE * strongest).collect();
    if seen.len() == parameters {
        return Some(DMatrix::identity(parameters, parameters));
    }
    let rows = DMatrix::from_fn(parameters, seen.len(), |p, k| v_t[(seen[k], p)] * lengths[p]);
    (!seen.is_empty()).then(|| rows.qr().q())
}
