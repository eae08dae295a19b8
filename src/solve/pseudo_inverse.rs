//! The inverse of a matrix of any shape and rank.

use nalgebra::DMatrix;

use super::decomposition::svd;

/// Singular values below this part of the largest count as zero.
pub(super) const RANK: f64 = 1e-10;

/// A matrix with its columns scaled to length one, and what they were divided by: their lengths, or one for columns of
/// zeros.
pub(crate) fn with_unit_columns(mut j: DMatrix<f64>) -> (DMatrix<f64>, Vec<f64>) {
    let lengths = j.column_iter().map(|c| if c.norm() > 0.0 { c.norm() } else { 1.0 });
    let lengths: Vec<f64> = lengths.collect();
    for (mut column, length) in j.column_iter_mut().zip(&lengths) {
        column.unscale_mut(*length);
    }
    (j, lengths)
}

/// `J⁺` (n × m) through the SVD of `J` with columns scaled to length one, the rank, and which unknowns have no
/// part in the null space.
pub(crate) fn pseudo_inverse(j: &DMatrix<f64>) -> (DMatrix<f64>, usize, Vec<bool>) {
    let n = j.ncols();
    let (mut scaled, scale) = with_unit_columns(j.clone());
    let (m, _) = scaled.shape();
    if m < n {
        scaled = scaled.resize_vertically(n, 0.0);
    }
    let svd = svd(scaled, true, true);
    // Both factors were asked for just above.
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return (DMatrix::zeros(n, m), 0, vec![false; n]) };
    let largest = svd.singular_values.max();
    let kept: Vec<bool> = svd.singular_values.iter().map(|s| *s > RANK * largest).collect();
    let mut determined = vec![true; n];
    let mut left = u.transpose();
    for (row, keep) in kept.iter().enumerate() {
        let factor = if *keep { 1.0 / svd.singular_values[row] } else { 0.0 };
        left.row_mut(row).scale_mut(factor);
        if !keep {
            for (k, d) in determined.iter_mut().enumerate() {
                *d &= v_t[(row, k)].abs() < 1e-6;
            }
        }
    }
    let mut inverse = v_t.transpose() * left;
    for (k, s) in scale.iter().enumerate() {
        inverse.row_mut(k).unscale_mut(*s);
    }
    (inverse.columns(0, m).into_owned(), kept.iter().filter(|k| **k).count(), determined)
}
