//! The Cholesky factor of a matrix of a few rows, for sums that are asked thousands of times.

use nalgebra::DVector;

/// `M = L Lᵀ` of a symmetric matrix of a few rows, by plain loops.
#[derive(Debug)]
pub(crate) struct SmallCholesky {
    n: usize,
    /// `L` by rows; what is above the diagonal is not used.
    l: Vec<f64>,
}

impl SmallCholesky {
    /// The factor of the matrix with these entries, of which the lower triangle is asked; `None` if it is not positive.
    pub(crate) fn of(n: usize, entry: impl Fn(usize, usize) -> f64) -> Option<Self> {
        let mut l = vec![0.0; n * n];
        for i in 0..n {
            for k in 0..=i {
                let (above, row) = l.split_at_mut(i * n);
                let other = if k == i { &row[..k] } else { &above[k * n..k * n + k] };
                let sum: f64 = other.iter().zip(&row[..k]).map(|(a, b)| a * b).sum();
                let left = entry(i, k) - sum;
                if k < i {
                    row[k] = left / above[k * n + k];
                } else if left > 0.0 {
                    row[k] = left.sqrt();
                } else {
                    return None;
                }
            }
        }
        Some(Self { n, l })
    }

    /// The diagonal of `L`.
    pub(crate) fn diagonal(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.n).map(|k| self.l[k * self.n + k])
    }

    /// `bᵀ M⁻¹ b`, the length squared of `L⁻¹ b`.
    pub(crate) fn form(&self, b: &DVector<f64>) -> f64 {
        let mut x = vec![0.0; self.n];
        for i in 0..self.n {
            let row = &self.l[i * self.n..i * self.n + i];
            let sum: f64 = row.iter().zip(&x).map(|(a, b)| a * b).sum();
            x[i] = (b[i] - sum) / self.l[i * self.n + i];
        }
        x.iter().map(|v| v * v).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Cholesky, DMatrix, dvector};

    #[test]
    fn it_agrees_with_nalgebra() {
        let a = DMatrix::from_fn(7, 5, |i, k| ((3 * i + 5 * k + i * k) % 7) as f64 - 2.5);
        let m = a.tr_mul(&a);
        let b = dvector![1.0, -2.0, 0.5, 3.0, -1.0];
        let (small, large) = (SmallCholesky::of(5, |i, k| m[(i, k)]).unwrap(), Cholesky::new(m).unwrap());
        for (one, other) in small.diagonal().zip(large.l().diagonal().iter()) {
            assert!((one - other).abs() < 1e-12 * other);
        }
        assert!((small.form(&b) - b.dot(&large.solve(&b))).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_positive_has_no_factor() {
        assert!(SmallCholesky::of(2, |i, k| if i == k { 1.0 } else { 2.0 }).is_none());
        assert!(SmallCholesky::of(1, |_, _| f64::NAN).is_none());
        assert!(SmallCholesky::of(0, |_, _| 1.0).is_some());
    }
}
