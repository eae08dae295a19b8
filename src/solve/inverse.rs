//! The inverse of a 6 × 6 matrix.

use nalgebra::Matrix6;

/// `M⁻¹` by elimination in place with exchanged rows; `None` if a pivot is zero or no number. A third of the time of an inverse
/// for any size, and taken by the million.
pub(crate) fn inverse6(matrix: &Matrix6<f64>) -> Option<Matrix6<f64>> {
    let mut rows = [[0.0; 6]; 6];
    for (i, row) in rows.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            *value = matrix[(i, j)];
        }
    }
    let mut exchanged = [0; 6];
    for k in 0..6 {
        let mut best = k;
        for i in k + 1..6 {
            if rows[i][k].abs() > rows[best][k].abs() {
                best = i;
            }
        }
        exchanged[k] = best;
        rows.swap(k, best);
        let inverse = 1.0 / rows[k][k];
        if !inverse.is_finite() {
            return None;
        }
        rows[k][k] = 1.0;
        for value in &mut rows[k] {
            *value *= inverse;
        }
        let pivot = rows[k];
        for (i, row) in rows.iter_mut().enumerate() {
            if i != k {
                let factor = std::mem::take(&mut row[k]);
                for (value, above) in row.iter_mut().zip(&pivot) {
                    *value -= factor * above;
                }
            }
        }
    }
    let mut inverse = Matrix6::from_fn(|i, j| rows[i][j]);
    // Rows that were exchanged before are columns that are exchanged afterwards.
    for k in (0..6).rev() {
        inverse.swap_columns(k, exchanged[k]);
    }
    Some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn it_inverts_whatever_the_order_of_the_rows() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for round in 0..200 {
            let mut m = Matrix6::from_fn(|_, _| rng.random_range(-1.0..1.0));
            if round % 2 == 0 {
                m[(0, 0)] = 0.0;
                m[(1, 0)] = 0.0;
            }
            let error = (m * inverse6(&m).unwrap() - Matrix6::identity()).norm();
            let condition = m.norm() * m.try_inverse().unwrap().norm();
            assert!(error < 1e-15 * condition, "{error:e} at {condition:e}");
        }
        let mut singular = Matrix6::identity();
        singular[(3, 3)] = 0.0;
        assert!(inverse6(&singular).is_none() && inverse6(&Matrix6::repeat(f64::NAN)).is_none());
    }
}
