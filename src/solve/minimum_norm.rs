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

/// Square systems whose condition is below this are solved by their inverse: there is nothing that is not seen.
const SOUND: f64 = 1e6;

/// [`minimum_norm`] for every column of `b`.
pub(crate) fn minimum_norms(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    if a.is_square() && !a.is_empty() && a.iter().chain(b.iter()).all(|v| v.is_finite()) {
        // The length of all entries bounds the largest singular value.
        let length = a.norm();
        if let Some(inverse) = a.clone().try_inverse().filter(|inverse| length * inverse.norm() < SOUND) {
            return inverse * b;
        }
    }
    let columns: Vec<DVector<f64>> = b.column_iter().map(|b| minimum_norm(a.clone(), &b.into_owned())).collect();
    DMatrix::from_fn(a.ncols(), b.ncols(), |i, k| columns[k][i])
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

    #[test]
    fn several_right_sides_are_solved_as_one_is() {
        let b = dmatrix![1.0, -2.0; 3.0, 0.5];
        for a in [dmatrix![2.0, 1.0; -1.0, 3.0], dmatrix![1.0, 1.0; 1.0, 1.0], dmatrix![1.0, 0.0, 2.0; 0.0, 1.0, 1.0]] {
            let all = minimum_norms(&a, &b);
            for k in 0..2 {
                assert!((all.column(k) - minimum_norm(a.clone(), &b.column(k).into_owned())).amax() < 1e-14);
            }
        }
    }
}
