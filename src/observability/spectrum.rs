//! Singular values of stacked rows.

use crate::solve::svd;
use nalgebra::DMatrix;

/// Singular values and right singular vectors of a stacked Jacobian.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Singular values in descending order, one for each parameter direction.
    pub values: Vec<f64>,
    /// Right singular vectors as columns, in the same order; without columns if they were not asked for.
    pub directions: DMatrix<f64>,
    /// Number of poses behind it.
    pub poses: usize,
}

impl Spectrum {
    /// Of rows (m × L) of finite numbers, through their QR decomposition: never through eigenvalues of `JᵀJ`, which
    /// lose the small ones.
    pub fn of(rows: &DMatrix<f64>, poses: usize, with_directions: bool) -> Self {
        let n = rows.ncols();
        let square = if rows.nrows() > n { rows.clone().qr().r() } else { rows.clone().resize_vertically(n, 0.0) };
        // Rows of absurdly small noise overflow when they are squared.
        let largest = square.amax().max(f64::MIN_POSITIVE);
        let svd = svd(square / largest, false, with_directions);
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|a, b| svd.singular_values[*b].total_cmp(&svd.singular_values[*a]));
        let directions = match &svd.v_t {
            Some(v) => DMatrix::from_fn(n, n, |row, k| v[(order[k], row)]),
            None => DMatrix::zeros(n, 0),
        };
        Self { values: order.iter().map(|k| svd.singular_values[*k] * largest).collect(), directions, poses }
    }
}
