//! How the rows of one sample are brought to unit covariance.

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::measurement::Rows;

/// `W` with `W Σ Wᵀ = I` for the covariance `Σ` of one sample.
pub(crate) enum Whitening {
    /// Independent rows, as most trackers report them: one factor for each.
    Diagonal(DVector<f64>),
    /// Lower triangular.
    Lower(DMatrix<f64>),
}

impl Whitening {
    /// For the covariance of a sample; `None` if it is not positive definite.
    pub(crate) fn of(covariance: &DMatrix<f64>) -> Option<Self> {
        let n = covariance.nrows();
        let independent = (0..n).all(|c| (0..n).all(|r| r == c || covariance[(r, c)] == 0.0));
        if independent {
            let variances = covariance.diagonal();
            let positive = variances.iter().all(|v| *v > 0.0);
            return positive.then(|| Self::Diagonal(variances.map(|v| 1.0 / v.sqrt())));
        }
        let lower = Cholesky::new(covariance.clone())?.unpack();
        lower.solve_lower_triangular(&DMatrix::identity(n, n)).map(Self::Lower)
    }

    /// Multiplies residual and derivatives by `W` and by `weight`, in place.
    pub(crate) fn apply(&self, weight: f64, rows: &mut Rows) {
        let columns = [rows.motion.as_mut_slice(), rows.own.as_mut_slice(), rows.residual.as_mut_slice()];
        let n = match self {
            Self::Diagonal(factors) => factors.len(),
            Self::Lower(w) => w.nrows(),
        };
        for column in columns.into_iter().flat_map(|all| all.chunks_exact_mut(n.max(1))) {
            match self {
                Self::Diagonal(factors) => {
                    for (value, factor) in column.iter_mut().zip(factors.iter()) {
                        *value *= factor * weight;
                    }
                }
                // From the last row up, so that the rows that are still needed have their old values.
                Self::Lower(w) => {
                    for row in (0..n).rev() {
                        let sum: f64 = (0..=row).map(|k| w[(row, k)] * column[k]).sum();
                        column[row] = sum * weight;
                    }
                }
            }
        }
    }

    /// `W⁻¹`, which turns white rows back into SI.
    pub(crate) fn inverse(&self) -> DMatrix<f64> {
        match self {
            Self::Diagonal(factors) => DMatrix::from_diagonal(&factors.map(|f| 1.0 / f)),
            // Lower triangular with a positive diagonal.
            Self::Lower(w) => w
                .solve_lower_triangular(&DMatrix::identity(w.nrows(), w.nrows()))
                .unwrap_or_else(|| DMatrix::zeros(w.nrows(), w.nrows())),
        }
    }

    /// `W` in full.
    pub(crate) fn to_matrix(&self) -> DMatrix<f64> {
        match self {
            Self::Diagonal(factors) => DMatrix::from_diagonal(factors),
            Self::Lower(w) => w.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_rows_have_unit_covariance() {
        let correlated = DMatrix::from_row_slice(3, 3, &[4.0, 1.0, 0.5, 1.0, 9.0, -2.0, 0.5, -2.0, 16.0]);
        for covariance in [correlated.clone(), DMatrix::from_diagonal(&correlated.diagonal())] {
            let whitening = Whitening::of(&covariance).unwrap();
            let w = whitening.to_matrix();
            assert!((&w * &covariance * w.transpose() - DMatrix::identity(3, 3)).amax() < 1e-15);
            let mut rows = Rows::sized(3, 2);
            rows.motion = DMatrix::from_fn(3, 6, |i, j| (i * 6 + j) as f64);
            rows.own = DMatrix::from_fn(3, 2, |i, j| 1.0 - (i + j) as f64);
            rows.residual = DVector::from_vec(vec![1.0, -2.0, 3.0]);
            let raw = rows.clone();
            whitening.apply(0.5, &mut rows);
            assert!((rows.motion - &w * raw.motion * 0.5).amax() < 1e-14);
            assert!((rows.own - &w * raw.own * 0.5).amax() < 1e-15);
            assert!((rows.residual - &w * raw.residual * 0.5).amax() < 1e-15);
        }
        assert!(Whitening::of(&DMatrix::zeros(2, 2)).is_none());
    }
}
