//! The trait of identifiers, and the two plain ones.

use nalgebra::DMatrix;

use crate::identification::error::IdentifyError;
use crate::identification::estimators::identification::Identification;
use crate::identification::judgement::weak_directions::DataSpectrum;
use crate::identification::problem::calibration_problem::CalibrationProblem;
use crate::identification::problem::prior::{Prior, PriorPolicy};
use crate::identification::task::{Task, Weights};
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

    /// The parameters of the mechanism alone, in the order of the mechanism, SI: the same as those of
    /// [`identify`](Self::identify), without covariance and misfit. For simulations that repeat a calibration by the
    /// thousand.
    ///
    /// # Errors
    /// As [`identify`](Self::identify).
    fn values(&self, task: &Task<'_>) -> Result<Vec<f64>, IdentifyError> {
        Ok(self.identify(task)?.mechanism_values())
    }
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

impl Identifier for LeastSquares {
    fn name(&self) -> &str {
        "least-squares"
    }

    fn identify(&self, task: &Task<'_>) -> Result<Identification, IdentifyError> {
        let (method, options) = self.settings();
        identify(task, method, &options)
    }

    fn values(&self, task: &Task<'_>) -> Result<Vec<f64>, IdentifyError> {
        let (method, options) = self.settings();
        // The faster steps end with one by QR, so that the values are the same to rounding.
        let options = LeastSquaresOptions { linear: LinearMethod::default(), ..options };
        values(task, method, &options).map_or_else(|| Ok(self.identify(task)?.mechanism_values()), Ok)
    }
}

impl LeastSquares {
    fn settings(&self) -> (LeastSquaresMethod, LeastSquaresOptions) {
        let method = if self.builtin { LeastSquaresMethod::ArgminGaussNewton } else { LeastSquaresMethod::GaussNewton };
        (method, LeastSquaresOptions { linear: LinearMethod::Qr, max_iterations: 50, ..Default::default() })
    }
}

impl Identifier for LevenbergMarquardt {
    fn name(&self) -> &str {
        "levenberg-marquardt"
    }

    fn identify(&self, task: &Task<'_>) -> Result<Identification, IdentifyError> {
        identify(task, LeastSquaresMethod::LevenbergMarquardt, &self.options)
    }

    fn values(&self, task: &Task<'_>) -> Result<Vec<f64>, IdentifyError> {
        let found = values(task, LeastSquaresMethod::LevenbergMarquardt, &self.options);
        found.map_or_else(|| Ok(self.identify(task)?.mechanism_values()), Ok)
    }
}

/// The parameters of a task that needs no prior and no second look at the noise: the plain case, without singular
/// values. `None` if it is another, or if the run does not converge.
fn values(task: &Task<'_>, method: LeastSquaresMethod, options: &LeastSquaresOptions) -> Option<Vec<f64>> {
    let n = task.mechanism.parameters().len();
    let unknowns = n + task.data.model().nuisance_parameters().len();
    if task.prior != PriorPolicy::None || task.data.row_count() < unknowns || task.mechanism.equations() > 6 {
        return None;
    }
    let mut problem = CalibrationProblem::new(task, None, 1.0).ok()?;
    let start = problem.start();
    let solution = least_squares(&mut problem, start, method, options).ok()?;
    determined(&solution.jacobian).then(|| solution.x.as_slice()[..n].to_vec())
}

/// True if no direction is without rows: the Gram matrix of the columns, scaled to length one, has no vanishing pivot.
fn determined(jacobian: &DMatrix<f64>) -> bool {
    /// Pivots of directions without rows are those of rounding.
    const LEAST: f64 = 1e-11;
    let mut scaled = jacobian.clone();
    scaled.column_iter_mut().for_each(|mut c| c.unscale_mut(c.norm().max(f64::MIN_POSITIVE)));
    (scaled.transpose() * &scaled)
        .cholesky()
        .is_some_and(|c| c.l_dirty().diagonal().iter().all(|pivot| pivot * pivot > LEAST))
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
        Identification::from_solution(task, problem, solution, noise_scale, weights, &[])
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
    let own = task.data.model().nuisance_parameters().len();
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

#[cfg(all(test, feature = "files"))]
mod tests {
    use super::*;
    use crate::files::Machine;
    use crate::identification::estimators::registry::{IDENTIFIERS, identifier};
    use crate::mechanism::Workspace;
    use crate::simulation::{as_dataset, draw_parameters, simulate, stream};

    #[test]
    fn values_alone_are_those_of_an_identification() {
        let machine = Machine::read(concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/table5.toml")).unwrap();
        let (nominal, noise) = (machine.mechanism.as_ref(), machine.noise.unwrap());
        let Workspace { convention, .. } = machine.workspace.unwrap();
        let mut rng = stream(5, 0);
        for poses in [7, 20] {
            let poses: Vec<_> = (0..poses).map(|_| machine.workspace.unwrap().random(&mut rng)).collect();
            let truth = nominal.with_values(&draw_parameters(nominal, None, &mut rng), nominal.home()).unwrap();
            let samples = simulate(nominal, truth.as_ref(), &poses, &convention, &noise, &mut rng).unwrap();
            let data = as_dataset(&samples, &convention, &noise);
            for prior in [PriorPolicy::None, PriorPolicy::Auto] {
                for name in IDENTIFIERS {
                    let identifier = identifier(name).unwrap();
                    let task = Task { prior, ..Task::new(nominal, &data) };
                    let (all, alone) = (identifier.identify(&task).unwrap(), identifier.values(&task).unwrap());
                    for (p, value) in all.parameters.iter().zip(alone) {
                        let sigma = p.sigma.unwrap();
                        assert!((p.value - value).abs() < 1e-4 * sigma, "{name}: {} {value}", p.spec.name);
                    }
                }
            }
        }
    }

    #[test]
    fn directions_without_rows_are_seen_by_pivots() {
        let full = DMatrix::from_fn(12, 5, |i, j| ((i * 7 + j * 13) % 11) as f64 + if i == j { 20.0 } else { 0.0 });
        assert!(determined(&full));
        let mut blind = full.clone();
        let sum = full.column(0) * 3.0 - full.column(3);
        blind.set_column(4, &sum);
        assert!(!determined(&blind));
    }
}
