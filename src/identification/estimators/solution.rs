//! From the solution of a least-squares problem to a result with covariance and misfit.

use crate::identification::error::IdentifyError;
use crate::identification::estimators::identification::{Estimate, Identification};
use crate::identification::judgement::goodness_of_fit::GoodnessOfFit;
use crate::identification::problem::calibration_problem::CalibrationProblem;
use crate::identification::problem::prior::Prior;
use crate::identification::task::{Task, Weights};
use crate::measurement::SamplePosition;
use crate::mechanism::ParameterSpec;
use crate::solve::{LeastSquaresSolution, pseudo_inverse};

impl Identification {
    /// Puts a solution of `problem` together with its covariance and misfit.
    ///
    /// `noise_scale` is the σ of the readings over the stated one that the covariance is stated for; `outliers` are the
    /// samples that are left out of the test of the residuals.
    ///
    /// # Errors
    /// [`IdentifyError`] if the rows cannot be evaluated at the solution.
    pub fn from_solution(
        task: &Task<'_>,
        problem: &CalibrationProblem<'_>,
        solution: &LeastSquaresSolution,
        noise_scale: f64,
        weights: Vec<f64>,
        outliers: &[SamplePosition],
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
        let misfit = match GoodnessOfFit::at(task, &solution.x, problem.poses(), outliers) {
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
            outliers: outliers.iter().map(|k| task.data.row(*k)).collect(),
            poses: problem.poses().to_vec(),
        })
    }
}
