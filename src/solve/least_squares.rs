//! Nonlinear least squares: the problem, the options, and the one function that runs a solver.

use std::sync::Arc;

use argmin::core::{Executor, Solver, State, TerminationReason};
use nalgebra::{DMatrix, DVector};
use thiserror::Error;

use super::linear::LinearMethod;
use super::state::SolverState;
use super::{GaussNewton, LevenbergMarquardt, gauss_newton};

/// Why a problem could not be evaluated at a point; the cause is the problem's own error.
pub type EvaluationError = Arc<dyn std::error::Error + Send + Sync>;

/// Minimise `½|r(x)|²`, `r: Rⁿ → Rᵐ`.
pub trait LeastSquaresProblem {
    /// `(m, n)`: rows of the residual and unknowns.
    fn shape(&self) -> (usize, usize);

    /// The residual `r` (m) and its Jacobian `∂r/∂x` (m × n) at `x`.
    ///
    /// # Errors
    /// The problem's own error if it has no value at `x`. At the start this ends the run; later the solver
    /// takes a shorter step.
    fn linearize(
        &mut self,
        x: &DVector<f64>,
        residual: &mut DVector<f64>,
        jacobian: &mut DMatrix<f64>,
    ) -> Result<(), EvaluationError>;
}

/// Which solver runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LeastSquaresMethod {
    /// Damped Gauss–Newton, with plain steps while they help.
    #[default]
    LevenbergMarquardt,
    /// Gauss–Newton by QR: full steps, as in the paper.
    GaussNewton,
    /// argmin's built-in Gauss–Newton on the normal equations, through argmin-math.
    ArgminGaussNewton,
}

/// When to stop and how to step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastSquaresOptions {
    /// Converged when a step is at most this part of the unknowns, both measured with the columns of `J`.
    pub step_tolerance: f64,
    /// Converged when the best linear step would move the residual by at most this part of its length, the
    /// cosine of the angle between `r` and the range of `J`.
    pub gradient_tolerance: f64,
    /// Converged when the residual is at most this long: an exact fit.
    pub residual_floor: f64,
    /// Damping `λ` of the first step relative to `Jᵀ J` with unit diagonal; 0 begins with Gauss–Newton.
    pub initial_damping: f64,
    /// Iterations after which the run is given up.
    pub max_iterations: u64,
    /// How the linear steps are computed.
    pub linear: LinearMethod,
}

impl Default for LeastSquaresOptions {
    fn default() -> Self {
        Self {
            step_tolerance: 1e-10,
            gradient_tolerance: 1e-9,
            residual_floor: 0.0,
            initial_damping: 0.0,
            max_iterations: 200,
            linear: LinearMethod::default(),
        }
    }
}

/// Why the iteration ended well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Convergence {
    /// The step became too small to matter.
    SmallStep,
    /// The residual is orthogonal to the columns of the Jacobian.
    SmallGradient,
    /// The residual is zero to the stated floor.
    ExactFit,
}

impl Convergence {
    /// The reason as a phrase.
    pub fn text(self) -> &'static str {
        match self {
            Self::SmallStep => "the step became negligible",
            Self::SmallGradient => "no further step reduces the residual",
            Self::ExactFit => "the fit is exact to rounding",
        }
    }
}

/// One accepted step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IterationRecord {
    /// `½|r|²` after the step.
    pub cost: f64,
    /// Largest number of the step, in the units of the unknowns.
    pub step: f64,
    /// Damping of the step.
    pub damping: f64,
}

/// A minimum, and how it was reached.
#[derive(Clone, Debug)]
pub struct LeastSquaresSolution {
    /// The minimiser.
    pub x: DVector<f64>,
    /// The residual there.
    pub residual: DVector<f64>,
    /// The Jacobian there.
    pub jacobian: DMatrix<f64>,
    /// `½|r|²` at the start.
    pub initial_cost: f64,
    /// Accepted steps in order.
    pub history: Vec<IterationRecord>,
    /// Why it ended.
    pub convergence: Convergence,
}

/// Why there is no minimum.
#[derive(Clone, Debug, Error)]
#[non_exhaustive]
pub enum SolveError {
    /// The iterations were used up, or no step helped.
    #[error("no convergence after {iterations} iterations: cost {cost:.6e}, last step {step:.3e}")]
    NoConvergence {
        /// Accepted steps.
        iterations: usize,
        /// `½|r|²` at the end.
        cost: f64,
        /// Largest number of the last step.
        step: f64,
        /// Where the run ended, for whoever wants to look at it; it is not a result.
        last: Box<LeastSquaresSolution>,
    },
    /// The linear system is singular and the solver does not damp.
    #[error("the least-squares system is singular after {iterations} iterations ({rows} rows, {unknowns} unknowns)")]
    Singular {
        /// Accepted steps.
        iterations: usize,
        /// Rows of the residual.
        rows: usize,
        /// Unknowns.
        unknowns: usize,
    },
    /// The problem has no value at the start.
    #[error("the problem cannot be evaluated at the start: {0}")]
    Start(EvaluationError),
    /// The problem has no value where it has to be evaluated.
    #[error("the problem cannot be evaluated after {iterations} iterations: {cause}")]
    Evaluation {
        /// Accepted steps.
        iterations: usize,
        /// The problem's own error.
        cause: EvaluationError,
    },
    /// A residual or Jacobian entry is NaN or infinite.
    #[error("the residual is not a finite number after {iterations} iterations")]
    NotFinite {
        /// Accepted steps.
        iterations: usize,
    },
}

/// What every solver of this module leaves behind for [`least_squares`].
pub(super) struct Progress {
    pub(super) residual: DVector<f64>,
    pub(super) jacobian: DMatrix<f64>,
    pub(super) initial_cost: f64,
    pub(super) history: Vec<IterationRecord>,
    pub(super) convergence: Option<Convergence>,
    pub(super) failure: Option<SolveError>,
}

impl Progress {
    pub(super) fn new(shape: (usize, usize)) -> Self {
        Self {
            residual: DVector::zeros(shape.0),
            jacobian: DMatrix::zeros(shape.0, shape.1),
            initial_cost: f64::NAN,
            history: Vec::new(),
            convergence: None,
            failure: None,
        }
    }

    pub(super) fn into_result(self, x: DVector<f64>) -> Result<LeastSquaresSolution, SolveError> {
        if let Some(failure) = self.failure {
            return Err(failure);
        }
        let cost = 0.5 * self.residual.norm_squared();
        let (iterations, step) = (self.history.len(), self.history.last().map_or(f64::NAN, |h| h.step));
        let solution = LeastSquaresSolution {
            x,
            residual: self.residual,
            jacobian: self.jacobian,
            initial_cost: self.initial_cost,
            history: self.history,
            convergence: self.convergence.unwrap_or(Convergence::SmallStep),
        };
        match self.convergence {
            Some(_) => Ok(solution),
            None => Err(SolveError::NoConvergence { iterations, cost, step, last: Box::new(solution) }),
        }
    }
}

/// A solver that keeps its [`Progress`] in itself.
pub(super) trait KeepsProgress {
    fn into_progress(self) -> Progress;
}

/// Minimises from `start`.
///
/// # Errors
/// [`SolveError`] unless the solver converged.
pub fn least_squares<O: LeastSquaresProblem>(
    problem: &mut O,
    start: DVector<f64>,
    method: LeastSquaresMethod,
    options: &LeastSquaresOptions,
) -> Result<LeastSquaresSolution, SolveError> {
    let shape = problem.shape();
    match method {
        LeastSquaresMethod::LevenbergMarquardt => {
            run(problem, start, LevenbergMarquardt::new(*options, shape), options)
        }
        LeastSquaresMethod::GaussNewton => run(problem, start, GaussNewton::new(*options, shape), options),
        LeastSquaresMethod::ArgminGaussNewton => gauss_newton::run_builtin(problem, start, options),
    }
}

fn run<O, S>(
    problem: &mut O,
    start: DVector<f64>,
    solver: S,
    options: &LeastSquaresOptions,
) -> Result<LeastSquaresSolution, SolveError>
where
    O: LeastSquaresProblem,
    S: for<'a> Solver<&'a mut O, SolverState<DVector<f64>>> + KeepsProgress,
{
    let run = Executor::new(problem, solver)
        .configure(|state: SolverState<DVector<f64>>| state.started(start, options.max_iterations))
        .timer(false)
        .ctrlc(false)
        .run()
        .map_err(|_| SolveError::NotFinite { iterations: 0 })?;
    let mut state = run.state;
    debug_assert!(!matches!(state.get_termination_reason(), Some(TerminationReason::Interrupt)));
    match state.param.take() {
        Some(x) => run.solver.into_progress().into_result(x),
        None => Err(SolveError::NotFinite { iterations: 0 }),
    }
}
