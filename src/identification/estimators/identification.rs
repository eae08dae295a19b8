//! Results of an identification.

use nalgebra::{DMatrix, DVector};

use crate::identification::judgement::goodness_of_fit::GoodnessOfFit;
use crate::identification::problem::calibration_problem::{CalibrationProblem, Weights};
use crate::identification::{IdentifyError, Prior, Task};
use crate::mechanism::ParameterSpec;
use crate::pose::Pose;
use crate::solve::{Convergence, IterationRecord, LeastSquaresProblem, LeastSquaresSolution, SolveError, svd};

/// One identified parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Specification of the parameter.
    pub spec: ParameterSpec,
    /// Where the identification started: the value in the mechanism file.
    pub start: f64,
    /// Identified value, SI.
    pub value: f64,
    /// Its 1σ; `None` if the data (and the prior) do not determine it.
    pub sigma: Option<f64>,
}

/// Parameters, covariance and how they were reached.
#[derive(Clone, Debug)]
pub struct Identification {
    /// Parameters of the mechanism, then those of the measurement.
    pub parameters: Vec<Estimate>,
    /// How many of them belong to the mechanism.
    pub mechanism_parameters: usize,
    /// Covariance of all of them, SI; undetermined directions are left out.
    pub covariance: DMatrix<f64>,
    /// Accepted steps.
    pub history: Vec<IterationRecord>,
    /// Why the iteration ended.
    pub convergence: Convergence,
    /// Rank of the rows, prior included; below the number of parameters some are not determined.
    pub rank: usize,
    /// True if tolerances were used as prior.
    pub prior: bool,
    /// Estimated σ of the readings over the stated one; 1 where the stated noise is taken as known.
    pub noise_scale: f64,
    /// Test of the residuals against the noise.
    pub misfit: GoodnessOfFit,
    /// Weight of each sample; below one only in robust fits.
    pub weights: Vec<f64>,
    /// Samples (positions in the data) that a robust fit judges to be gross errors.
    pub outliers: Vec<usize>,
    /// Predicted pose of each sample, base frame.
    pub poses: Vec<Pose>,
}

/// Singular values below this part of the largest count as zero.
const RANK: f64 = 1e-10;

impl Identification {
    /// Puts a solution of `problem` together with its covariance and misfit.
    ///
    /// `noise_scale` is the σ of the readings over the stated one that the covariance is stated for.
    ///
    /// # Errors
    /// [`IdentifyError`] if the rows cannot be evaluated at the solution.
    pub fn from_solution(
        task: &Task<'_>,
        problem: &CalibrationProblem<'_>,
        solution: &LeastSquaresSolution,
        noise_scale: f64,
        weights: Vec<f64>,
        outliers: Vec<usize>,
    ) -> Result<Self, IdentifyError> {
        let n = solution.x.len();
        let (pseudo_inverse, mut rank, mut determined) = pseudo_inverse(&solution.jacobian);
        if let Some((held, takes_part)) = problem.prior().and_then(Prior::held) {
            // What was only held in place is not determined.
            rank = n.saturating_sub(held);
            for (d, part) in determined.iter_mut().zip(takes_part) {
                *d &= !part;
            }
        }
        let covariance = match task.weights {
            // With J = W H the rows have unit covariance, and so the covariance is J⁺ J⁺ᵀ.
            Weights::Noise => &pseudo_inverse * pseudo_inverse.transpose(),
            Weights::MillimetresAndRadians => {
                // The rows have the covariance of the readings, in mm and rad; J⁺ carries it to the parameters.
                problem.covariance_through(&pseudo_inverse) * noise_scale.powi(2)
            }
        };
        let misfit = match GoodnessOfFit::at(task, &solution.x, problem.poses(), &outliers) {
            // Data that were misread can lead to a model that does not reach its own samples.
            Err(IdentifyError::Solve(_)) => GoodnessOfFit::beyond_measure(task),
            other => other?,
        };
        if !misfit.noise_known && misfit.degrees_of_freedom == 0 {
            // Nothing tells how large the noise is, and so nothing how well a parameter is known.
            determined.fill(false);
        }
        let specs = task.mechanism.parameters();
        let own = task.data.model().nuisance_parameters();
        let start = problem.start();
        let estimate = |(k, spec): (usize, &ParameterSpec)| Estimate {
            spec: spec.clone(),
            start: start[k],
            value: solution.x[k],
            sigma: determined[k].then(|| covariance[(k, k)].sqrt()),
        };
        let parameters: Vec<Estimate> = specs.iter().chain(own).enumerate().map(estimate).collect();
        debug_assert_eq!(parameters.len(), n);
        Ok(Self {
            parameters,
            mechanism_parameters: specs.len(),
            covariance,
            history: solution.history.clone(),
            convergence: solution.convergence,
            rank,
            prior: problem.prior().is_some_and(Prior::informs),
            noise_scale,
            misfit,
            weights,
            outliers,
            poses: problem.poses().to_vec(),
        })
    }

    /// Values of the mechanism's parameters.
    pub fn mechanism_values(&self) -> Vec<f64> {
        self.parameters[..self.mechanism_parameters].iter().map(|p| p.value).collect()
    }

    /// Values of the measurement's own parameters.
    pub fn own_values(&self) -> Vec<f64> {
        self.parameters[self.mechanism_parameters..].iter().map(|p| p.value).collect()
    }

    /// Covariance of the mechanism's parameters alone.
    pub fn mechanism_covariance(&self) -> DMatrix<f64> {
        let n = self.mechanism_parameters;
        self.covariance.view((0, 0), (n, n)).into_owned()
    }

    /// Correlation of every two parameters; 0 where one is not determined.
    pub fn correlation(&self) -> DMatrix<f64> {
        let sigma: DVector<f64> = self.covariance.diagonal().map(f64::sqrt);
        let n = sigma.len();
        DMatrix::from_fn(n, n, |i, j| {
            let product = sigma[i] * sigma[j];
            if product > 0.0 { self.covariance[(i, j)] / product } else { 0.0 }
        })
    }
}

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

/// Residual and Jacobian of a problem at `x`, checked to be numbers: a decomposition of NaN need not end.
pub(crate) fn linearized(
    problem: &mut CalibrationProblem<'_>,
    x: &DVector<f64>,
) -> Result<(DVector<f64>, DMatrix<f64>), IdentifyError> {
    let (m, n) = problem.shape();
    let (mut r, mut j) = (DVector::zeros(m), DMatrix::zeros(m, n));
    problem
        .linearize(x, &mut r, &mut j)
        .map_err(|cause| IdentifyError::Solve(SolveError::Evaluation { iterations: 0, cause }))?;
    if r.iter().chain(j.iter()).any(|v| !v.is_finite()) {
        return Err(IdentifyError::Solve(SolveError::NotFinite { iterations: 0 }));
    }
    Ok((r, j))
}
