//! Linear least squares where there may be too few equations.

use nalgebra::{DMatrix, DVector};

/// Directions weaker than this part of the strongest one are not seen.
const UNSEEN: f64 = 1e-9;

/// The shortest `x` with the least `|a x - b|`; not a number where `a` or `b` is none.
pub(crate) fn minimum_norm(a: DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    if a.is_empty() {
        return DVector::zeros(a.ncols());
    }
    let unknown = DVector::from_element(a.ncols(), f64::NAN);
    if a.iter().chain(b.iter()).any(|v| !v.is_finite()) {
        return unknown;
    }
    let svd = a.svd(true, true);
    let largest = svd.singular_values.max();
    svd.solve(b, UNSEEN * largest).unwrap_or(unknown)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{dmatrix, dvector};

    #[test]
    fn directions_that_are_not_seen_stay_at_zero() {
        let x = minimum_norm(dmatrix![1.0, 0.0, 1.0; 0.0, 0.0, 0.0], &dvector![2.0, 5.0]);
        assert!((x - dvector![1.0, 0.0, 1.0]).amax() < 1e-12);
        assert!(minimum_norm(DMatrix::zeros(0, 3), &DVector::zeros(0)) == DVector::zeros(3));
        assert!(minimum_norm(dmatrix![f64::NAN], &dvector![1.0])[0].is_nan());
    }
}
