//! Residual and Jacobian at one point.

use nalgebra::{DMatrix, DVector};

use super::least_squares::{LeastSquaresProblem, SolveError};

/// Residual (m) and Jacobian (m × n) of a problem at `x`, checked to be numbers: a decomposition of NaN need not end.
pub(crate) fn linearized(
    problem: &mut impl LeastSquaresProblem,
    x: &DVector<f64>,
) -> Result<(DVector<f64>, DMatrix<f64>), SolveError> {
    let (m, n) = problem.shape();
    let (mut r, mut j) = (DVector::zeros(m), DMatrix::zeros(m, n));
    problem.linearize(x, &mut r, &mut j).map_err(|cause| SolveError::Evaluation { iterations: 0, cause })?;
    if r.iter().chain(j.iter()).any(|v| !v.is_finite()) {
        return Err(SolveError::NotFinite { iterations: 0 });
    }
    Ok((r, j))
}
