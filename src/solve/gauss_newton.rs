//! Gauss–Newton: the paper's iteration by QR, and argmin's built-in solver as an independent check.

use std::cell::RefCell;

use argmin::core::{Executor, IterState, Jacobian, KV, Operator, Problem, Solver, State as _, TerminationReason};
use argmin::solver::gaussnewton::GaussNewton as Builtin;
use nalgebra::{DMatrix, DVector};

use super::least_squares::{Convergence, IterationRecord, KeepsProgress, LeastSquaresSolution, Progress, SolveError};
use super::linear::{LinearMethod, column_norms, relative_size, solve_step};
use super::state::SolverState;
use super::{LeastSquaresOptions, LeastSquaresProblem};

/// Full steps `δ = -J⁺ r` by QR until they are negligible; no damping, no line search.
///
/// # Requirements on the problem
/// A start so near that full steps converge, and a Jacobian of full column rank.
pub(super) struct GaussNewton {
    options: LeastSquaresOptions,
    progress: Progress,
}

impl GaussNewton {
    /// A solver for a problem of that shape.
    pub(super) fn new(options: LeastSquaresOptions, shape: (usize, usize)) -> Self {
        Self { options, progress: Progress::new(shape) }
    }

    fn evaluate(&mut self, problem: &mut impl LeastSquaresProblem, x: &DVector<f64>) -> bool {
        let p = &mut self.progress;
        let iterations = p.history.len();
        if let Err(cause) = problem.linearize(x, &mut p.residual, &mut p.jacobian) {
            p.failure = Some(match iterations {
                0 => SolveError::Start(cause),
                _ => SolveError::Evaluation { iterations, cause },
            });
        } else if p.residual.iter().chain(p.jacobian.iter()).any(|v| !v.is_finite()) {
            p.failure = Some(SolveError::NotFinite { iterations });
        }
        p.failure.is_none()
    }
}

impl KeepsProgress for GaussNewton {
    fn into_progress(self) -> Progress {
        self.progress
    }
}

type State = SolverState<DVector<f64>>;

impl<O: LeastSquaresProblem> Solver<&mut O, State> for GaussNewton {
    fn name(&self) -> &str {
        "Gauss-Newton by QR"
    }

    fn init(
        &mut self,
        problem: &mut Problem<&mut O>,
        mut state: State,
    ) -> Result<(State, Option<KV>), argmin::core::Error> {
        let (Some(problem), Some(x)) = (problem.problem.as_mut(), state.param.as_ref()) else {
            return Err(argmin::core::Error::msg("the solver was started without a point"));
        };
        if !self.evaluate(*problem, x) {
            return Ok((state.stop(TerminationReason::SolverExit("no start".into())), None));
        }
        self.progress.initial_cost = 0.5 * self.progress.residual.norm_squared();
        state.cost = self.progress.initial_cost;
        Ok((state, None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<&mut O>,
        mut state: State,
    ) -> Result<(State, Option<KV>), argmin::core::Error> {
        let (Some(problem), Some(mut x)) = (problem.problem.as_mut(), state.param.take()) else {
            return Err(argmin::core::Error::msg("the solver was started without a point"));
        };
        let scale = column_norms(&self.progress.jacobian);
        let norm = self.progress.residual.norm();
        if norm <= self.options.residual_floor {
            self.progress.convergence = Some(Convergence::ExactFit);
            state.param = Some(x);
            return Ok((state.stop(TerminationReason::SolverConverged), None));
        }
        let Some(step) = solve_step(&self.progress.jacobian, &self.progress.residual, &scale, 0.0, LinearMethod::Qr)
        else {
            let (rows, unknowns) = self.progress.jacobian.shape();
            let iterations = self.progress.history.len();
            self.progress.failure = Some(SolveError::Singular { iterations, rows, unknowns });
            state.param = Some(x);
            return Ok((state.stop(TerminationReason::SolverExit("singular".into())), None));
        };
        let size = relative_size(&scale, &step.delta, &x);
        x += &step.delta;
        if !self.evaluate(*problem, &x) {
            // A full step led out of the problem's domain. Where the run stood before is kept, as no result.
            x -= &step.delta;
            self.progress.failure = None;
            self.evaluate(*problem, &x);
            state.param = Some(x);
            return Ok((state.stop(TerminationReason::SolverExit("failed".into())), None));
        }
        let cost = 0.5 * self.progress.residual.norm_squared();
        self.progress.history.push(IterationRecord { cost, step: step.delta.amax(), damping: 0.0 });
        state.cost = cost;
        state.param = Some(x);
        if step.moved <= self.options.gradient_tolerance * norm {
            self.progress.convergence = Some(Convergence::SmallGradient);
        } else if size <= self.options.step_tolerance {
            self.progress.convergence = Some(Convergence::SmallStep);
        }
        let done = self.progress.convergence.is_some();
        Ok((if done { state.stop(TerminationReason::SolverConverged) } else { state }, None))
    }
}

/// The problem as argmin's built-in solver wants it: residual and Jacobian apart, by shared reference.
struct Bridge<'a, O> {
    problem: RefCell<&'a mut O>,
    shape: (usize, usize),
}

impl<O: LeastSquaresProblem> Bridge<'_, O> {
    fn evaluate(&self, x: &DVector<f64>) -> Result<(DVector<f64>, DMatrix<f64>), argmin::core::Error> {
        let (mut r, mut j) = (DVector::zeros(self.shape.0), DMatrix::zeros(self.shape.0, self.shape.1));
        self.problem
            .borrow_mut()
            .linearize(x, &mut r, &mut j)
            .map_err(|cause| argmin::core::Error::msg(cause.to_string()))?;
        Ok((r, j))
    }
}

impl<O: LeastSquaresProblem> Operator for Bridge<'_, O> {
    type Param = DVector<f64>;
    type Output = DVector<f64>;
    fn apply(&self, x: &DVector<f64>) -> Result<DVector<f64>, argmin::core::Error> {
        Ok(self.evaluate(x)?.0)
    }
}

impl<O: LeastSquaresProblem> Jacobian for Bridge<'_, O> {
    type Param = DVector<f64>;
    type Jacobian = DMatrix<f64>;
    fn jacobian(&self, x: &DVector<f64>) -> Result<DMatrix<f64>, argmin::core::Error> {
        Ok(self.evaluate(x)?.1)
    }
}

/// Runs argmin's built-in Gauss–Newton. It stops on the change of the residual's length, so its history
/// repeats the last state, and a run that did not converge is turned into an error here.
pub(super) fn run_builtin<O: LeastSquaresProblem>(
    problem: &mut O,
    start: DVector<f64>,
    options: &LeastSquaresOptions,
) -> Result<LeastSquaresSolution, SolveError> {
    let shape = problem.shape();
    let (mut r, mut j) = (DVector::zeros(shape.0), DMatrix::zeros(shape.0, shape.1));
    problem.linearize(&start, &mut r, &mut j).map_err(SolveError::Start)?;
    let initial_norm = r.norm();
    let tolerance = (options.step_tolerance * initial_norm).max(f64::MIN_POSITIVE);
    let solver = Builtin::new().with_tolerance(tolerance).map_err(|_| SolveError::NotFinite { iterations: 0 })?;
    let run = Executor::new(Bridge { problem: RefCell::new(problem), shape }, solver)
        .configure(|state: IterState<_, (), _, (), _, f64>| state.param(start).max_iters(options.max_iterations))
        .timer(false)
        .run();
    let singular = SolveError::Singular { iterations: 0, rows: shape.0, unknowns: shape.1 };
    let run = run.map_err(|_| singular)?;
    let iterations = run.state.get_iter() as usize;
    let converged = matches!(run.state.get_termination_reason(), Some(TerminationReason::SolverConverged));
    let Some(x) = run.state.get_param().cloned() else { return Err(SolveError::NotFinite { iterations }) };
    let Some(bridge) = run.problem.problem else { return Err(SolveError::NotFinite { iterations }) };
    let (residual, jacobian) = bridge.evaluate(&x).map_err(|cause| {
        let cause: Box<dyn std::error::Error + Send + Sync> = cause.to_string().into();
        SolveError::Evaluation { iterations, cause: cause.into() }
    })?;
    if residual.iter().any(|v| !v.is_finite()) {
        return Err(SolveError::NotFinite { iterations });
    }
    let mut progress = Progress::new(shape);
    let record = IterationRecord { cost: 0.5 * residual.norm_squared(), step: f64::NAN, damping: 0.0 };
    progress.history = vec![record; iterations];
    progress.initial_cost = 0.5 * initial_norm * initial_norm;
    progress.residual = residual;
    progress.jacobian = jacobian;
    progress.convergence = converged.then_some(Convergence::SmallStep);
    progress.into_result(x)
}
