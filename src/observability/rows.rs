//! Rows below one another, and an inverse that follows as rows come and go.

use nalgebra::{Cholesky, DMatrix, Dyn};

/// Blocks (6 × L each) below one another, and below them the unit rows of a prior if there is one.
pub fn stacked(blocks: &[DMatrix<f64>], directions: usize, prior: bool) -> DMatrix<f64> {
    let own = 6 * blocks.len();
    let mut rows = DMatrix::zeros(own + if prior { directions } else { 0 }, directions);
    for (k, block) in blocks.iter().enumerate() {
        rows.rows_mut(6 * k, 6).copy_from(block);
    }
    if prior {
        rows.rows_mut(own, directions).fill_with_identity();
    }
    rows
}

/// Pads a wide matrix with zero rows until it is square.
pub(super) fn at_least_square(rows: DMatrix<f64>) -> DMatrix<f64> {
    let (m, n) = rows.shape();
    if m < n { rows.resize_vertically(n, 0.0) } else { rows }
}

/// Turns `M⁻¹` into `(M ± JᵀJ)⁻¹` for six rows `J` (Sherman, Morrison and Woodbury) and returns the logarithm of the ratio
/// of the determinants of `M`. `None`, and nothing done, if a pivot of `I ± J M⁻¹ Jᵀ` is not above `smallest_pivot`: the
/// result would be inaccurate.
pub(crate) fn update_inverse(
    inverse: &mut DMatrix<f64>,
    rows: &DMatrix<f64>,
    sign: f64,
    smallest_pivot: f64,
) -> Option<f64> {
    let across = &*inverse * rows.transpose();
    let middle = DMatrix::identity(6, 6) + rows * &across * sign;
    let accurate = |c: &Cholesky<f64, Dyn>| c.l_dirty().diagonal().min() > smallest_pivot.sqrt();
    let factor = Cholesky::new(middle).filter(accurate)?;
    let solved = factor.solve(&across.transpose());
    inverse.gemm(-sign, &across, &solved, 1.0);
    Some(factor.ln_determinant())
}
