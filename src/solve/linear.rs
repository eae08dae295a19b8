//! One linear least-squares step, `min_δ |J δ + r|² + λ |D δ|²`, in two ways.

use nalgebra::{Cholesky, DMatrix, DVector};

/// How a step is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LinearMethod {
    /// Householder QR of the stacked `[J; √λ D]`: the condition of `J` is not squared.
    Qr,
    /// Cholesky of the normal equations with columns scaled to length one, the faster way. It is used
    /// while the scaled pivots stay above 1e-9, for the last step above 1e-7; below, QR takes over.
    #[default]
    NormalThenQr,
}

/// A step, and what it does.
#[derive(Clone, Debug)]
pub(super) struct LinearStep {
    /// `δ`.
    pub delta: DVector<f64>,
    /// Length of `J δ`: how far the residual moves, in units of the residual.
    pub moved: f64,
    /// True if it has the digits to be the last one.
    pub precise: bool,
}

/// Smallest squared pivot of the scaled Cholesky factor that is still trusted; the step then has about six
/// correct digits, and the iteration repairs the rest.
const SMALLEST_PIVOT: f64 = 1e-9;
/// The same for a last step, which nothing repairs.
const SMALLEST_LAST_PIVOT: f64 = 1e-7;

/// Diagonal entries of R below this part of the largest are rounding, for columns of length one.
const SINGULAR: f64 = 1e-13;

/// Lengths of the columns; a column of zeros counts as one, so that its unknown stays where it is.
pub(super) fn column_norms(j: &DMatrix<f64>) -> DVector<f64> {
    usable(&DVector::from_iterator(j.ncols(), j.column_iter().map(|c| c.norm())))
}

/// Lengths of columns as [`column_norms`] has them.
pub(super) fn usable(norms: &DVector<f64>) -> DVector<f64> {
    norms.map(|n| if n > 0.0 { n } else { 1.0 })
}

/// Measures the columns; false if an entry is not finite, which its column's length tells without another pass.
pub(super) fn measure(j: &DMatrix<f64>, norms: &mut DVector<f64>) -> bool {
    for (norm, column) in norms.iter_mut().zip(j.column_iter()) {
        *norm = column.norm();
    }
    norms.iter().all(|n| n.is_finite())
}

/// Longest projection of `r` on a column: the gradient in units of the residual.
pub(super) fn slope(j: &DMatrix<f64>, norms: &DVector<f64>, r: &DVector<f64>) -> f64 {
    j.tr_mul(r).component_div(&usable(norms)).amax()
}

/// Length of the step as a part of the unknowns.
pub(super) fn relative_size(columns: &DVector<f64>, delta: &DVector<f64>, x: &DVector<f64>) -> f64 {
    columns.component_mul(delta).norm() / columns.component_mul(x).norm().max(f64::MIN_POSITIVE)
}

/// Solves for the step; `None` if the system is singular to rounding.
pub(super) fn solve_step(
    j: &DMatrix<f64>,
    r: &DVector<f64>,
    scale: &DVector<f64>,
    damping: f64,
    method: LinearMethod,
) -> Option<LinearStep> {
    let normal = match method {
        LinearMethod::NormalThenQr => by_normal_equations(j, r, scale, damping),
        LinearMethod::Qr => None,
    };
    let (delta, precise) = match normal {
        Some((delta, smallest)) => (delta, smallest >= SMALLEST_LAST_PIVOT),
        None => (by_qr(j, r, scale, damping)?, true),
    };
    let moved = (j * &delta).norm();
    (delta.iter().all(|v| v.is_finite()) && moved.is_finite()).then_some(LinearStep { delta, moved, precise })
}

/// The step and the smallest squared pivot.
fn by_normal_equations(
    j: &DMatrix<f64>,
    r: &DVector<f64>,
    scale: &DVector<f64>,
    damping: f64,
) -> Option<(DVector<f64>, f64)> {
    let n = j.ncols();
    // A product of matrices is blocked; `j.tr_mul(j)` would take it apart into dot products, at twice the time.
    let mut gram = j.transpose() * j;
    let mut rhs = j.tr_mul(r);
    let inverse = scale.map(|s| 1.0 / s);
    for c in 0..n {
        // Cholesky reads the lower triangle alone.
        for k in c..n {
            gram[(k, c)] *= inverse[k] * inverse[c];
        }
        gram[(c, c)] += damping;
        rhs[c] *= -inverse[c];
    }
    let factor = Cholesky::new(gram)?;
    let l = factor.l_dirty();
    let smallest = (0..n).map(|k| l[(k, k)] * l[(k, k)]).fold(f64::INFINITY, f64::min);
    if smallest < SMALLEST_PIVOT {
        return None;
    }
    factor.solve_mut(&mut rhs);
    rhs.component_div_assign(scale);
    Some((rhs, smallest))
}

fn by_qr(j: &DMatrix<f64>, r: &DVector<f64>, scale: &DVector<f64>, damping: f64) -> Option<DVector<f64>> {
    let (m, n) = j.shape();
    let extra = if damping > 0.0 { n } else { 0 };
    if m + extra < n {
        return None;
    }
    let mut stacked = DMatrix::zeros(m + extra, n);
    for c in 0..n {
        let inverse = 1.0 / scale[c];
        for k in 0..m {
            stacked[(k, c)] = j[(k, c)] * inverse;
        }
        if extra > 0 {
            stacked[(m + c, c)] = damping.sqrt();
        }
    }
    let mut rhs = DVector::zeros(m + extra);
    rhs.rows_mut(0, m).copy_from(r);
    rhs.neg_mut();
    let qr = stacked.qr();
    qr.q_tr_mul(&mut rhs);
    let upper = qr.unpack_r();
    let largest = upper.diagonal().amax();
    if !(upper.diagonal().iter().all(|d| d.abs() > SINGULAR * largest)) {
        return None;
    }
    let mut delta = upper.solve_upper_triangular(&rhs.rows(0, n).into_owned())?;
    delta.component_div_assign(scale);
    Some(delta)
}
