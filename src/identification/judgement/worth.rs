//! What an estimate is worth: covariance, rank and misfit from one linearization at its values.

use nalgebra::{DMatrix, DVector};

use crate::identification::error::IdentifyError;
use crate::identification::estimators::fit::Fit;
use crate::identification::estimators::identification::{Estimate, Identification};
use crate::identification::judgement::goodness_of_fit::GoodnessOfFit;
use crate::identification::problem::calibration_problem::CalibrationProblem;
use crate::identification::problem::prior::Prior;
use crate::identification::task::Weights;
use crate::mechanism::ParameterSpec;
use crate::solve::{Triangle, pseudo_inverse};

/// Covariance of all unknowns, the rank, and which unknowns have no part in what is not determined.
type Known = (DMatrix<f64>, usize, Vec<bool>);

impl Identification {
    /// Judges the fit of a problem, which holds the prior and the size of the noise that it was made with.
    ///
    /// # Errors
    /// [`IdentifyError`] if the rows cannot be evaluated there.
    pub fn of(problem: &mut CalibrationProblem<'_>, fit: &Fit) -> Result<Self, IdentifyError> {
        problem.move_to(&fit.values);
        let problem = &*problem;
        let n = fit.values.len();
        let (misfit, (covariance, mut rank, mut determined)) = match problem.data_at(&fit.values) {
            Ok((residual, jacobian)) => {
                let plain = GoodnessOfFit::rows(problem, fit, &residual, &jacobian);
                let known = match problem.weights() {
                    Weights::Noise => by_noise(problem, fit, &plain, residual, jacobian),
                    Weights::MillimetresAndRadians => unweighted(problem, fit)?,
                };
                (GoodnessOfFit::of_rows(problem, &plain), known)
            }
            // Data that were misread can lead to a model that does not reach its own samples.
            Err(IdentifyError::Solve(_)) => {
                (GoodnessOfFit::beyond_measure(problem), (DMatrix::zeros(n, n), 0, vec![false; n]))
            }
            Err(other) => return Err(other),
        };
        if let Some((held, takes_part)) = problem.prior().and_then(Prior::held) {
            // What was only held in place is not determined.
            rank = n.saturating_sub(held);
            for (d, part) in determined.iter_mut().zip(takes_part) {
                *d &= !part;
            }
        }
        if !misfit.noise_known && misfit.degrees_of_freedom == 0 {
            // Nothing tells how large the noise is, and so nothing how well a parameter is known.
            determined.fill(false);
        }
        let start = problem.start();
        let estimate = |(k, spec): (usize, &ParameterSpec)| Estimate {
            spec: spec.clone(),
            start: start[k],
            value: fit.values[k],
            sigma: determined[k].then(|| covariance[(k, k)].sqrt()),
        };
        Ok(Self {
            parameters: problem.parameters().enumerate().map(estimate).collect(),
            mechanism_parameters: problem.mechanism_parameters(),
            covariance,
            history: fit.history.clone(),
            convergence: fit.convergence,
            rank,
            prior: problem.prior().is_some_and(Prior::informs),
            noise_scale: problem.noise_scale(),
            misfit,
            weights: fit.weights.clone(),
            outliers: fit.gross.iter().map(|k| problem.data().row(*k)).collect(),
            poses: problem.poses().to_vec(),
        })
    }
}

/// With `J = W H J_b` the rows have unit covariance, so that the covariance is `(JᵀJ)⁺`. `plain` are the rows of the data
/// for the noise as stated, and `jacobian` all of them.
fn by_noise(
    problem: &CalibrationProblem<'_>,
    fit: &Fit,
    plain: &Triangle,
    mut residual: DVector<f64>,
    mut jacobian: DMatrix<f64>,
) -> Known {
    let scale = problem.noise_scale();
    let alike = fit.gross.is_empty() && fit.weights.iter().all(|w| *w == 1.0);
    let mut rows = if alike {
        plain.clone()
    } else {
        for ((first, n), weight) in problem.sample_rows().into_iter().zip(&fit.weights) {
            residual.rows_mut(first, n).scale_mut(weight.sqrt());
            jacobian.rows_mut(first, n).scale_mut(weight.sqrt());
        }
        Triangle::of(&jacobian, &residual)
    };
    rows.scale(1.0 / scale);
    if let Some(prior) = problem.prior() {
        let (mut r, mut j) = (DVector::zeros(prior.rows()), DMatrix::zeros(prior.rows(), fit.values.len()));
        prior.write(&fit.values, 0, &mut r, &mut j);
        rows.add(&j, &r, 0..prior.rows(), 1.0);
    }
    rows.covariance()
}

/// Rows in millimetres and radians have the covariance of the readings; `J⁺` carries it to the parameters.
fn unweighted(problem: &CalibrationProblem<'_>, fit: &Fit) -> Result<Known, IdentifyError> {
    let (inverse, rank, determined) = pseudo_inverse(&problem.all_at(&fit.values)?.1);
    Ok((problem.covariance_through(&inverse) * problem.noise_scale().powi(2), rank, determined))
}
