//! Many rows of a linear least-squares problem, folded into a triangle.
//!
//! `[J r] = Q [R c; 0 ρ]`: of `min_δ |J δ + r|` the triangle `R` (n × n), the numbers `c = Qᵀr` and the length `ρ` of the part
//! that no column explains say as much as all `m` rows, and no condition is squared. Rows are folded in by blocks that stay in
//! the cache (QR of tall matrices, Demmel, Grigori, Hoemmen, Langou 2012), always the same ones, so that results do not
//! depend on threads.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::decomposition::svd;
use super::pseudo_inverse::{RANK, pseudo_inverse, with_unit_columns};

/// Rows of a block: with 42 unknowns a hundred kilobytes.
const BLOCK: usize = 256;
/// Columns of length one whose singular values are all above this are independent; the Gram matrix can tell it.
const CLEAR: f64 = 1e-5;

/// The triangle of some rows.
#[derive(Clone, Debug)]
pub(crate) struct Triangle {
    /// `[R c; 0 ρ]`, (n + 1) × (n + 1), upper.
    upper: DMatrix<f64>,
    /// Rows that were folded in.
    rows: usize,
}

impl Triangle {
    /// Of no rows, for `n` unknowns.
    pub(crate) fn empty(n: usize) -> Self {
        Self { upper: DMatrix::zeros(n + 1, n + 1), rows: 0 }
    }

    /// Of a Jacobian (m × n) and a residual (m).
    pub(crate) fn of(jacobian: &DMatrix<f64>, residual: &DVector<f64>) -> Self {
        let mut all = Self::empty(jacobian.ncols());
        all.add(jacobian, residual, 0..residual.len(), 1.0);
        all
    }

    /// Adds some of the rows of a system, each multiplied by `weight`.
    pub(crate) fn add(
        &mut self,
        jacobian: &DMatrix<f64>,
        residual: &DVector<f64>,
        rows: std::ops::Range<usize>,
        weight: f64,
    ) {
        let n = jacobian.ncols();
        for first in rows.clone().step_by(BLOCK) {
            let count = BLOCK.min(rows.end - first);
            self.fold(count, |stacked, from| {
                stacked.view_mut((from, 0), (count, n)).copy_from(&jacobian.rows(first, count));
                stacked.view_mut((from, n), (count, 1)).copy_from(&residual.rows(first, count));
                if weight != 1.0 {
                    stacked.rows_mut(from, count).scale_mut(weight);
                }
            });
            self.rows += count;
        }
    }

    /// Multiplies all rows so far.
    pub(crate) fn scale(&mut self, factor: f64) {
        self.upper *= factor;
    }

    /// Factors the triangle so far with `count` rows below it, which `write` puts from a row on.
    fn fold(&mut self, count: usize, write: impl FnOnce(&mut DMatrix<f64>, usize)) {
        let n = self.upper.ncols();
        let above = if self.rows == 0 { 0 } else { n };
        // Rows of zeros fill up what would have fewer rows than columns.
        let mut stacked = DMatrix::zeros((above + count).max(n), n);
        stacked.rows_mut(0, above).copy_from(&self.upper.rows(0, above));
        write(&mut stacked, above);
        self.upper = stacked.qr().unpack_r();
    }

    /// Rows that were folded in.
    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    /// `[R c; 0 ρ]`.
    pub(crate) fn upper(&self) -> &DMatrix<f64> {
        &self.upper
    }

    /// `R`, with the same Gram matrix as `J`.
    pub(crate) fn jacobian(&self) -> DMatrix<f64> {
        let n = self.upper.ncols() - 1;
        self.upper.view((0, 0), (n, n)).into_owned()
    }

    /// Length of the part of the residual that the columns explain: how far the linear step moves the rows.
    pub(crate) fn explained(&self) -> f64 {
        let n = self.upper.ncols() - 1;
        self.upper.view((0, n), (n, 1)).norm()
    }

    /// Squared length of what the columns do not explain of the residual, and the rank.
    pub(crate) fn misfit(&self) -> (f64, usize) {
        let n = self.upper.ncols() - 1;
        let own = self.upper[(n, n)].powi(2);
        let (unit, _) = with_unit_columns(self.jacobian());
        if independent(&unit, CLEAR) {
            return (own, n);
        }
        let svd = svd(unit, true, false);
        let limit = RANK * svd.singular_values.max();
        let mut left = self.upper.view((0, n), (n, 1)).column(0).into_owned();
        let mut rank = 0;
        if let Some(u) = &svd.u {
            for k in (0..n).filter(|k| svd.singular_values[*k] > limit) {
                rank += 1;
                let along = u.column(k).dot(&left);
                left.axpy(-along, &u.column(k), 1.0);
            }
        }
        (own + left.norm_squared(), rank)
    }

    /// `(JᵀJ)⁺` (n × n), the rank, and which unknowns have no part in the null space.
    pub(crate) fn covariance(&self) -> (DMatrix<f64>, usize, Vec<bool>) {
        let r = self.jacobian();
        let n = r.ncols();
        let (unit, lengths) = with_unit_columns(r.clone());
        let inverse =
            if independent(&unit, CLEAR) { unit.solve_upper_triangular(&DMatrix::identity(n, n)) } else { None };
        let Some(mut inverse) = inverse else {
            let (inverse, rank, determined) = pseudo_inverse(&r);
            return (&inverse * inverse.transpose(), rank, determined);
        };
        for (mut row, length) in inverse.row_iter_mut().zip(lengths) {
            row.unscale_mut(length);
        }
        (&inverse * inverse.transpose(), n, vec![true; n])
    }
}

/// True if every singular value of a matrix is at least `limit`. Near the limit, and where rounding of the squares could hide
/// it, the answer is no.
pub(crate) fn independent(a: &DMatrix<f64>, limit: f64) -> bool {
    exceeds(&gram(a), limit)
}

/// `AᵀA`; a product of matrices is blocked, `tr_mul` would take it apart into dot products.
pub(crate) fn gram(a: &DMatrix<f64>) -> DMatrix<f64> {
    a.transpose() * a
}

/// [`independent`] of a matrix with this [`gram`], by a Cholesky factor of `AᵀA - limit² I`.
pub(crate) fn exceeds(gram: &DMatrix<f64>, limit: f64) -> bool {
    let (n, trace, square) = (gram.nrows(), gram.trace(), limit * limit);
    // A Cholesky factor of positive numbers is that of a matrix at most this far away (Higham, theorem 10.3).
    let rounding = 4.0 * (n + 2) as f64 * f64::EPSILON * trace;
    if !(trace.is_finite() && rounding < square) {
        return false;
    }
    let mut shifted = gram.clone();
    for k in 0..n {
        shifted[(k, k)] -= square + rounding;
    }
    Cholesky::new(shifted).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::singular_values;
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    /// Rows with columns of very different lengths, the last two of which depend on each other if `deficient`.
    fn system(m: usize, n: usize, deficient: bool) -> (DMatrix<f64>, DVector<f64>) {
        let mut rng = ChaCha8Rng::seed_from_u64((m * 100 + n) as u64);
        let mut j = DMatrix::from_fn(m, n, |_, k| rng.random_range(-1.0..1.0) * 10f64.powi(k as i32 % 7 - 3));
        if deficient {
            let twin = j.column(n - 2) * 3.0;
            j.set_column(n - 1, &twin);
        }
        (j, DVector::from_fn(m, |_, _| rng.random_range(-1.0..1.0)))
    }

    #[test]
    fn it_says_what_all_rows_say() {
        for (m, n, deficient) in [(5, 8, false), (40, 8, false), (40, 8, true), (1000, 11, false), (1000, 11, true)] {
            let (j, r) = system(m, n, deficient);
            let whole = Triangle::of(&j, &r);
            let mut parts = Triangle::empty(n);
            for range in [0..m / 3, m / 3..m] {
                parts.add(&j, &r, range, 0.5);
            }
            assert_eq!((whole.rows(), parts.rows()), (m, m));
            let (inverse, rank, determined) = pseudo_inverse(&j);
            let expected = &inverse * inverse.transpose();
            // What the columns leave, by the projection itself.
            let left = &r - &j * (&inverse * &r);
            for (triangle, weight) in [(&whole, 1.0), (&parts, 0.25)] {
                let (covariance, found, which) = triangle.covariance();
                assert_eq!((found, &which), (rank, &determined), "{m} rows, {n} unknowns");
                let scaled = &covariance * weight - &expected;
                for k in 0..n {
                    let scale = expected[(k, k)].sqrt();
                    assert!((0..n).all(|i| scaled[(k, i)].abs() <= 1e-10 * scale * expected[(i, i)].sqrt()));
                }
                let (squares, found) = triangle.misfit();
                assert_eq!(found, rank);
                if rank == n {
                    let explained = (r.norm_squared() - left.norm_squared()).sqrt();
                    assert!((triangle.explained() / weight.sqrt() - explained).abs() < 1e-9 * r.norm());
                }
                assert!((squares / weight - left.norm_squared()).abs() < 1e-9 * r.norm_squared(), "{squares}");
            }
        }
    }

    #[test]
    fn columns_that_differ_by_rounding_are_told_apart() {
        // Läuchli: the normal equations lose the small entries altogether.
        let tiny = 1e-9;
        let mut a = DMatrix::zeros(600, 2);
        a.row_mut(0).fill(1.0);
        a[(300, 0)] = tiny;
        a[(599, 1)] = tiny;
        let r = Triangle::of(&a, &DVector::zeros(600)).jacobian();
        assert!((singular_values(r)[1] - tiny).abs() < 1e-6 * tiny);
    }

    #[test]
    fn independence_is_that_of_the_singular_values() {
        let (j, _) = system(60, 6, false);
        let (unit, _) = with_unit_columns(j);
        let least = singular_values(unit.clone()).min();
        assert!(independent(&unit, 0.999 * least) && !independent(&unit, 1.001 * least));
        let (twins, _) = system(60, 6, true);
        assert!(!independent(&with_unit_columns(twins).0, 1e-7), "below what squares can tell");
        assert!(!independent(&DMatrix::repeat(3, 3, f64::NAN), 1e-3));
    }
}
