//! Do the residuals look like the noise?

use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Test of the model against the noise.
///
/// The whitened residual is projected off *all* columns of the Jacobian before its length is taken. The test
/// is then one of the model and not of the estimator: neither a prior nor unweighted rows, which leave more
/// residual than necessary, change it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct GoodnessOfFit {
    /// Length squared of the projected whitened residual, for the noise as stated.
    pub chi_square: f64,
    /// Rows less the rank of the Jacobian.
    pub degrees_of_freedom: usize,
    /// True if the size of the noise is known, so that the test means something.
    pub noise_known: bool,
}

impl GoodnessOfFit {
    /// Estimated σ of the readings over the stated one; `None` without degrees of freedom.
    pub fn scale(&self) -> Option<f64> {
        (self.degrees_of_freedom > 0).then(|| (self.chi_square / self.degrees_of_freedom as f64).sqrt())
    }

    /// How much farther a prediction goes wrong because the size of the noise is itself estimated, `√(ν / (ν - 2))` with ν
    /// degrees of freedom: σ of Student's distribution over that of the normal one. It is 1 where the noise is known, and
    /// `None` where two degrees of freedom or fewer leave no finite σ.
    pub fn widening(&self) -> Option<f64> {
        let free = self.degrees_of_freedom as f64;
        match self.noise_known {
            true => Some(1.0),
            false => (free > 2.0).then(|| (free / (free - 2.0)).sqrt()),
        }
    }

    /// Probability of a misfit at least this large by chance; `None` where the noise is not known or every row
    /// is used up by parameters.
    pub fn p_value(&self) -> Option<f64> {
        if !self.noise_known || self.degrees_of_freedom == 0 {
            return None;
        }
        if self.chi_square.is_infinite() {
            return Some(0.0);
        }
        ChiSquared::new(self.degrees_of_freedom as f64).ok().map(|d| d.sf(self.chi_square))
    }
}
