//! The normal equations of a model, and what their solution leaves.

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::design_matrix::Block;
use crate::diagnosis::linear::kept_rows::KeptRows;

/// Relative ridge on the normal equations: rounding.
const RIDGE: f64 = 1e-13;

/// `L⁻¹` with `L Lᵀ` the normal equations: `square` with the precision of the prior in its corner.
pub(crate) fn inverse_factor(
    mut normal: DMatrix<f64>,
    precision: &DMatrix<f64>,
) -> Result<DMatrix<f64>, DiagnoseError> {
    let z = normal.nrows();
    let mut corner = normal.view_mut((0, 0), precision.shape());
    corner += precision;
    // Columns that vanish, or that repeat others, are held where they are.
    let largest = normal.diagonal().map(|v| if v > 0.0 { v } else { 1.0 });
    for k in 0..z {
        normal[(k, k)] += RIDGE * largest[k];
    }
    let factor = Cholesky::new(normal).ok_or(DiagnoseError::Singular)?;
    let mut inverse = DMatrix::identity(z, z);
    for k in 0..z {
        // Above the diagonal the inverse is zero as well.
        let l = factor.l_dirty().view((k, k), (z - k, z - k));
        if !l.solve_lower_triangular_mut(&mut inverse.view_mut((k, k), (z - k, 1))) {
            return Err(DiagnoseError::Singular);
        }
    }
    Ok(inverse)
}

/// `r - Z s` over the rows that count.
pub(crate) fn residual(kept: &KeptRows, blocks: &[Block], s: &DVector<f64>) -> DVector<f64> {
    let mut residual = kept.r.clone();
    let a_t = &kept.table.a_t;
    let mut at = 0;
    for block in blocks {
        let (p, rows) = (block.columns.len(), a_t.ncols() - block.first);
        let columns = a_t.view((block.columns.start, block.first), (p, rows));
        residual.rows_mut(block.first, rows).gemv_tr(-1.0, &columns, &s.rows(at, p), 1.0);
        at += p;
    }
    for (first, n) in kept.left_out.iter().map(|k| kept.table.rows[*k]) {
        residual.rows_mut(first, n).fill(0.0);
    }
    residual
}
