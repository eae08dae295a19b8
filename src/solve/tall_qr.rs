//! The triangular factor of a matrix that is much taller than wide.
//!
//! Blocks of rows are decomposed one after the other, each below the triangle of those before (TSQR: Demmel, Grigori,
//! Hoemmen, Langou 2012). It is as stable as a QR decomposition of the whole, which the normal equations are not, and the
//! orthogonal factor is never formed.

use nalgebra::DMatrix;

/// Rows of a block, at least.
const AT_ONCE: usize = 256;

/// `R` (n × n) of `A = Q R`; signs of its rows are free. Rows of zeros fill it where `A` has fewer rows than columns.
pub(crate) fn triangle(a: &DMatrix<f64>) -> DMatrix<f64> {
    let n = a.ncols();
    let at_once = AT_ONCE.max(4 * n);
    let mut r = DMatrix::zeros(n, n);
    let mut first = 0;
    while first < a.nrows() {
        let rows = at_once.min(a.nrows() - first);
        let mut block = DMatrix::zeros(n + rows, n);
        block.rows_mut(0, n).copy_from(&r);
        block.rows_mut(n, rows).copy_from(&a.rows(first, rows));
        r = block.qr().unpack_r();
        first += rows;
    }
    r
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_has_the_singular_values_of_the_whole() {
        for rows in [3, 255, 256, 1000] {
            let a = DMatrix::from_fn(rows, 5, |i, k| ((7 * i + 11 * k * k + i * k) % 23) as f64 - 11.0);
            let (whole, of_r) = (a.singular_values(), triangle(&a).singular_values());
            for k in 0..5.min(rows) {
                assert!((whole[k] - of_r[k]).abs() < 1e-12 * whole[0], "{rows} {k}");
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
        assert!((triangle(&a).singular_values()[1] - tiny).abs() < 1e-6 * tiny);
    }
}
