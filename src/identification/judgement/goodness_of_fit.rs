//! Do the residuals look like the noise?

use nalgebra::DVector;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::identification::estimators::identification::{linearized, with_unit_columns};
use crate::identification::problem::calibration_problem::{CalibrationProblem, Weights};
use crate::identification::{IdentifyError, Task};
use crate::measurement::SamplePosition;
use crate::pose::Pose;

/// Test of the model against the noise.
///
/// The whitened residual is projected off *all* columns of the Jacobian before its length is taken. The test
/// is then one of the model and not of the estimator: neither a prior nor unweighted rows, which leave more
/// residual than necessary, change it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GoodnessOfFit {
    /// Length squared of the projected whitened residual, for the noise as stated.
    pub chi_square: f64,
    /// Rows less the rank of the Jacobian.
    pub degrees_of_freedom: usize,
    /// True if the size of the noise is known, so that the test means something.
    pub noise_known: bool,
}

impl GoodnessOfFit {
    /// The test at `x`, where the samples have these `poses`, without the samples that are `left_out`.
    pub(crate) fn at(
        task: &Task<'_>,
        x: &DVector<f64>,
        poses: &[Pose],
        left_out: &[SamplePosition],
    ) -> Result<Self, IdentifyError> {
        let weighted = Task { weights: Weights::Noise, ..*task };
        let kept: Vec<usize> = (0..task.data.len()).filter(|k| !left_out.contains(&SamplePosition(*k))).collect();
        let data = task.data.subset(&kept);
        let mut problem = CalibrationProblem::new(&Task { data: &data, ..weighted }, None, 1.0)?;
        problem.start_from(kept.iter().map(|k| poses[*k]));
        let (mut r, j) = linearized(&mut problem, x)?;
        let (j, _) = with_unit_columns(j);
        let (m, n) = j.shape();
        let svd = j.svd(true, false);
        let largest = svd.singular_values.max();
        let mut rank = 0;
        if let Some(u) = &svd.u {
            for k in (0..n.min(m)).filter(|k| svd.singular_values[*k] > 1e-10 * largest) {
                rank += 1;
                let along = u.column(k).dot(&r);
                r.axpy(-along, &u.column(k), 1.0);
            }
        }
        Ok(Self { chi_square: r.norm_squared(), degrees_of_freedom: m - rank, noise_known: task.data.noise.known })
    }

    /// The verdict on a model that cannot even be evaluated at its samples.
    pub(crate) fn beyond_measure(task: &Task<'_>) -> Self {
        let free = task.data.row_count().saturating_sub(task.mechanism.parameters().len());
        Self { chi_square: f64::INFINITY, degrees_of_freedom: free, noise_known: task.data.noise.known }
    }

    /// Estimated σ of the readings over the stated one; `None` without degrees of freedom.
    pub fn scale(&self) -> Option<f64> {
        (self.degrees_of_freedom > 0).then(|| (self.chi_square / self.degrees_of_freedom as f64).sqrt())
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
