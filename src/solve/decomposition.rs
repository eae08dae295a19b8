//! Decompositions that end whatever the numbers are.
//!
//! nalgebra's iterations go on for ever where a number is not finite. Here the values of such a matrix are NaN, which no
//! test of a rank or of a limit passes.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, DimDiff, DimMin, DimMinimum, DimSub, OMatrix, OVector, SVD, SymmetricEigen, U1};

/// The singular value decomposition, values from the largest to the smallest.
pub(crate) fn svd<R, C>(mut matrix: OMatrix<f64, R, C>, left: bool, right: bool) -> SVD<f64, R, C>
where
    R: DimMin<C>,
    C: Dim,
    DimMinimum<R, C>: DimSub<U1>,
    DefaultAllocator: Allocator<R, C>
        + Allocator<C>
        + Allocator<R>
        + Allocator<DimDiff<DimMinimum<R, C>, U1>>
        + Allocator<DimMinimum<R, C>, C>
        + Allocator<R, DimMinimum<R, C>>
        + Allocator<DimMinimum<R, C>>,
{
    let finite = matrix.iter().all(|v| v.is_finite());
    if !finite {
        matrix.fill(0.0);
    }
    let mut found = SVD::new(matrix, left, right);
    if !finite {
        found.singular_values.fill(f64::NAN);
    }
    found
}

/// Its values alone.
pub(crate) fn singular_values<R, C>(matrix: OMatrix<f64, R, C>) -> OVector<f64, DimMinimum<R, C>>
where
    R: DimMin<C>,
    C: Dim,
    DimMinimum<R, C>: DimSub<U1>,
    DefaultAllocator: Allocator<R, C>
        + Allocator<C>
        + Allocator<R>
        + Allocator<DimDiff<DimMinimum<R, C>, U1>>
        + Allocator<DimMinimum<R, C>, C>
        + Allocator<R, DimMinimum<R, C>>
        + Allocator<DimMinimum<R, C>>,
{
    svd(matrix, false, false).singular_values
}

/// Eigenvalues and eigenvectors of a symmetric matrix.
pub(crate) fn symmetric_eigen<D>(mut matrix: OMatrix<f64, D, D>) -> SymmetricEigen<f64, D>
where
    D: Dim + DimSub<U1>,
    DefaultAllocator: Allocator<D, D> + Allocator<DimDiff<D, U1>> + Allocator<D>,
{
    let finite = matrix.iter().all(|v| v.is_finite());
    if !finite {
        matrix.fill(0.0);
    }
    let mut found = SymmetricEigen::new(matrix);
    if !finite {
        found.eigenvalues.fill(f64::NAN);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, Matrix3};

    #[test]
    fn numbers_that_are_not_finite_come_to_an_end() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut m = DMatrix::from_fn(6, 4, |i, k| ((3 * i + 5 * k) % 7) as f64);
            assert!(singular_values(m.clone()) == m.singular_values());
            m[(2, 1)] = bad;
            let found = svd(m, true, true);
            assert!(found.singular_values.iter().all(|v| v.is_nan()));
            assert!(found.u.unwrap().iter().chain(found.v_t.unwrap().iter()).all(|v| v.is_finite()));
            let mut s = Matrix3::new(2.0, 1.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 5.0);
            assert!((symmetric_eigen(s).eigenvalues.max() - 5.0).abs() < 1e-14);
            s[(0, 1)] = bad;
            assert!(symmetric_eigen(s).eigenvalues.iter().all(|v| v.is_nan()));
        }
    }
}
