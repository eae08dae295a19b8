//! The trait of identifiers, the two plain ones, and the registry.

use super::problem::{CalibrationProblem, Weights};
use super::weak_directions::DataSpectrum;
use super::{Identification, IdentifyError, Prior, PriorPolicy, Robust, Task};
use crate::observability::DECIDED;
use crate::solve::{
    LeastSquaresMethod, LeastSquaresOptions, LeastSquaresSolution, LinearMethod, SolveError, least_squares,
};

/// Finds the parameters of a mechanism from data.
///
/// An implementation turns a [`Task`] into an [`Identification`]; [`CalibrationProblem`] gives it the whitened
/// residual and Jacobian, and [`Identification::from_solution`] covariance and misfit. The suite
/// `conformance::identifier` checks it.
pub trait Identifier: Send + Sync {
    /// Name on the command line and in results.
    fn name(&self) -> &str;

    /// Identifies.
    ///
    /// # Errors
    /// [`IdentifyError`]; a result is only returned after convergence.
    fn identify(&self, task: &Task<'_>) -> Result<Identification, IdentifyError>;
}

/// The paper's iteration (section 4.1): Gauss–Newton on the stacked error model until the step is negligible.
///
/// With [`Weights::MillimetresAndRadians`] it is the paper's estimator to the letter; it then loses a factor of
/// about three in the parameters against weighted rows. Its covariance is that of this estimator, not the
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

/// Names of the identifiers that [`identifier`] makes.
pub const IDENTIFIERS: &[&str] = &["levenberg-marquardt", "least-squares", "robust"];

/// The identifier of a name, with its default settings.
pub fn identifier(name: &str) -> Option<Box<dyn Identifier>> {
    match name {
        "levenberg-marquardt" => Some(Box::new(LevenbergMarquardt::default())),
        "least-squares" => Some(Box::new(LeastSquares::default())),
        "robust" => Some(Box::new(Robust::default())),
        _ => None,
    }
}

impl Identifier for LeastSquares {
    fn name(&self) -> &str {
        "least-squares"
    }

    fn identify(&self, task: &Task<'_>) -> Result<Identification, IdentifyError> {
        let method = if self.builtin { LeastSquaresMethod::ArgminGaussNewton } else { LeastSquaresMethod::GaussNewton };
        let options = LeastSquaresOptions { linear: LinearMethod::Qr, max_iterations: 50, ..Default::default() };
        identify(task, method, &options)
    }
}

impl Identifier for LevenbergMarquardt {
    fn name(&self) -> &str {
        "levenberg-marquardt"
    }

    fn identify(&self, task: &Task<'_>) -> Result<Identification, IdentifyError> {
        identify(task, LeastSquaresMethod::LevenbergMarquardt, &self.options)
    }
}

/// A step of this many σ, all parameters together, is none.
const NEGLIGIBLE: f64 = 0.1;
/// Rounds of refitting when both the prior and the size of the noise matter.
const NOISE_ROUNDS: usize = 8;

fn identify(
    task: &Task<'_>,
    method: LeastSquaresMethod,
    options: &LeastSquaresOptions,
) -> Result<Identification, IdentifyError> {
    let mut scale = 1.0;
    let mut found = solve(task, scale, method, options)?;
    if task.data.noise.known {
        return Ok(found);
    }
    // Only the ratio of the σ is known. Their size enters the covariance, and the balance with a prior, so the
    // fit is repeated with the estimated size until that settles.
    for _ in 0..NOISE_ROUNDS {
        let Some(estimated) = found.misfit.scale().filter(|s| *s > 0.0 && s.is_finite()) else { break };
        if (estimated / scale - 1.0).abs() < 0.01 {
            break;
        }
        scale = estimated;
        let history = found.history;
        found = solve(task, scale, method, options)?;
        found.history = history;
    }
    Ok(found)
}

fn solve(
    task: &Task<'_>,
    noise_scale: f64,
    method: LeastSquaresMethod,
    options: &LeastSquaresOptions,
) -> Result<Identification, IdentifyError> {
    let prior = choose_prior(task, noise_scale)?;
    let mut problem = CalibrationProblem::new(task, prior, noise_scale)?;
    let finish = |problem: &CalibrationProblem<'_>, solution: &LeastSquaresSolution| {
        let weights = vec![1.0; task.data.len()];
        Identification::from_solution(task, problem, solution, noise_scale, weights, Vec::new())
    };
    let start = problem.start();
    match least_squares(&mut problem, start, method, options) {
        Ok(solution) => finish(&problem, &solution),
        // The block of a redundant mechanism leaves out how contradictions among its joints bend the pose, so that the
        // last steps do not keep what they promise; they are then far below the noise.
        Err(SolveError::NoConvergence { last, .. }) if task.mechanism.equations() > 6 && to_go(&last) < NEGLIGIBLE => {
            finish(&problem, &last)
        }
        Err(SolveError::NoConvergence { iterations, cost, step, last }) => {
            let shown = Box::new(finish(&problem, &last)?);
            Err(IdentifyError::NotConverged {
                cause: SolveError::NoConvergence { iterations, cost, step, last },
                last: shown,
            })
        }
        Err(cause) => Err(cause.into()),
    }
}

/// How far the next Gauss–Newton step would move the whitened rows: its length in σ.
fn to_go(solution: &LeastSquaresSolution) -> f64 {
    solution.jacobian.clone().qr().q().tr_mul(&solution.residual).norm()
}

/// The prior that the policy asks for, given how well the data decide.
///
/// # Errors
/// [`IdentifyError::TooFewRows`] if the data alone cannot determine the parameters and there is no prior.
pub fn choose_prior(task: &Task<'_>, noise_scale: f64) -> Result<Option<Prior>, IdentifyError> {
    let own = task.data.model().own_parameters().len();
    if task.data.row_count() == 0 {
        return Err(IdentifyError::Empty);
    }
    let unweighted = task.weights == Weights::MillimetresAndRadians;
    let tolerances = || Prior::from_tolerance(task.mechanism, task.convention);
    match task.prior {
        PriorPolicy::Tolerance if unweighted => return Err(IdentifyError::PriorWithoutWeights),
        PriorPolicy::Tolerance => return tolerances().map(Some),
        PriorPolicy::Auto | PriorPolicy::None => {}
    }
    let spectrum = DataSpectrum::at_start(task, noise_scale)?;
    let undecided = task.prior == PriorPolicy::Auto && !unweighted && spectrum.smallest() < DECIDED;
    if let (true, Ok(prior)) = (undecided, tolerances()) {
        return Ok(Some(prior));
    }
    let (rows, samples) = (task.data.row_count(), task.data.len());
    let unknowns = task.mechanism.parameters().len() + own;
    if rows < unknowns {
        let per_sample = rows.div_ceil(samples).max(1);
        return Err(IdentifyError::TooFewRows { rows, samples, unknowns, needed: unknowns.div_ceil(per_sample) });
    }
    let unseen = spectrum.unseen();
    Ok(unseen.map(|directions| Prior::holding(task.mechanism, &spectrum.scale, &directions)))
}
