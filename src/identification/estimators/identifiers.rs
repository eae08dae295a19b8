//! The trait of identifiers, and the two plain ones.

use crate::identification::error::IdentifyError;
use crate::identification::estimators::fit::Fit;
use crate::identification::estimators::identification::Identification;
use crate::identification::judgement::goodness_of_fit::GoodnessOfFit;
use crate::identification::problem::calibration_problem::CalibrationProblem;
use crate::identification::task::Task;
use crate::solve::{
    LeastSquaresMethod, LeastSquaresOptions, LeastSquaresSolution, LinearMethod, SolveError, Triangle, least_squares,
};

/// Finds the parameters of a mechanism from data.
///
/// An implementation minimises a [`CalibrationProblem`], which gives it the whitened residual and Jacobian; covariance and
/// misfit follow from where it ended. The suite `conformance::identifier` checks it.
pub trait Identifier: Send + Sync {
    /// Name on the command line and in results.
    fn name(&self) -> &str;

    /// Finds the values that fit a problem best. Iterations begin at [`CalibrationProblem::guess`];
    /// [`CalibrationProblem::choose_prior`] and [`CalibrationProblem::scale_noise`] leave in the problem which prior and which
    /// noise the fit was made with.
    ///
    /// # Errors
    /// [`IdentifyError`]; a result is only returned after convergence.
    fn estimate(&self, problem: &mut CalibrationProblem<'_>) -> Result<Fit, IdentifyError>;

    /// Estimates, and says what the estimate is worth.
    ///
    /// # Errors
    /// As [`estimate`](Self::estimate).
    fn identify(&self, task: &Task<'_>) -> Result<Identification, IdentifyError> {
        let mut problem = CalibrationProblem::new(task)?;
        let fit = self.estimate(&mut problem)?;
        Identification::of(&mut problem, &fit)
    }
}

/// The paper's iteration (section 4.1): Gauss–Newton on the stacked error model until the step is negligible.
///
/// With [`Weights::MillimetresAndRadians`](crate::identification::Weights) it is the paper's estimator to the letter; it then
/// loses a factor of about three in the parameters against weighted rows. Its covariance is that of this estimator, not the
/// bound.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LeastSquares {
    /// Use argmin's built-in Gauss–Newton instead of the QR steps of this crate.
    pub builtin: bool,
}

/// Levenberg–Marquardt on rows weighted by the noise: the maximum-likelihood estimate, and with a prior the
/// most probable one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevenbergMarquardt {
    /// When to stop and how to step.
    pub options: LeastSquaresOptions,
}

impl Identifier for LeastSquares {
    fn name(&self) -> &str {
        "least-squares"
    }

    fn estimate(&self, problem: &mut CalibrationProblem<'_>) -> Result<Fit, IdentifyError> {
        let method = if self.builtin { LeastSquaresMethod::ArgminGaussNewton } else { LeastSquaresMethod::GaussNewton };
        let options = LeastSquaresOptions { linear: LinearMethod::Qr, max_iterations: 50, ..Default::default() };
        estimate(problem, method, &options)
    }
}

impl Identifier for LevenbergMarquardt {
    fn name(&self) -> &str {
        "levenberg-marquardt"
    }

    fn estimate(&self, problem: &mut CalibrationProblem<'_>) -> Result<Fit, IdentifyError> {
        estimate(problem, LeastSquaresMethod::LevenbergMarquardt, &self.options)
    }
}

/// A step of this many σ, all parameters together, is none.
const NEGLIGIBLE: f64 = 0.1;
/// Rounds of refitting when both the prior and the size of the noise matter.
const NOISE_ROUNDS: usize = 8;

fn estimate(
    problem: &mut CalibrationProblem<'_>,
    method: LeastSquaresMethod,
    options: &LeastSquaresOptions,
) -> Result<Fit, IdentifyError> {
    problem.scale_noise(1.0);
    let mut fit = solve(problem, method, options)?;
    if problem.data().noise.known {
        return Ok(fit);
    }
    // Only the ratio of the σ is known. Their size enters the covariance, and the balance with a prior, so the
    // fit is repeated with the estimated size until that settles.
    for _ in 0..NOISE_ROUNDS {
        let misfit = GoodnessOfFit::of(problem, &fit)?;
        let Some(estimated) = misfit.scale().filter(|s| *s > 0.0 && s.is_finite()) else { break };
        if (estimated / problem.noise_scale() - 1.0).abs() < 0.01 {
            break;
        }
        problem.scale_noise(estimated);
        problem.begin_at(fit.values.clone());
        let history = fit.history;
        fit = solve(problem, method, options)?;
        fit.history = history;
    }
    Ok(fit)
}

fn solve(
    problem: &mut CalibrationProblem<'_>,
    method: LeastSquaresMethod,
    options: &LeastSquaresOptions,
) -> Result<Fit, IdentifyError> {
    problem.choose_prior(problem.noise_scale())?;
    let samples = problem.data().len();
    let guess = problem.guess();
    match least_squares(problem, guess, method, options) {
        Ok(solution) => Ok(Fit::new(&solution, samples)),
        // The last steps need not keep what they promise: the block of a redundant mechanism leaves out how contradictions
        // among its joints bend the pose, and along a motion that no reading sees steps are as long as they are idle. What is
        // left to gain is then far below the noise.
        Err(SolveError::NoConvergence { last, .. }) if to_go(&last) < NEGLIGIBLE => Ok(Fit::new(&last, samples)),
        Err(cause) => Err(IdentifyError::without_minimum(cause, samples)),
    }
}

/// How far the next Gauss–Newton step would move the whitened rows: its length in σ.
fn to_go(solution: &LeastSquaresSolution) -> f64 {
    Triangle::of(&solution.jacobian, &solution.residual).explained()
}
