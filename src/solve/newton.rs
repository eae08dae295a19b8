//! Newton's method for six equations in six unknowns, with static sizes.
//!
//! Problem: find `p` with `f(p) = 0`, `f: P → R⁶`, where `P` need not be a vector space (a pose is not). The
//! step `δ` solves `J δ = -f` by LU (eq. 11 of the paper, which writes the inverse); [`NewtonProblem::step`]
//! carries it out on `P`. A step is halved while it does not reduce `|f|`, at most twenty times.

use argmin::core::{Executor, KV, Problem, Solver, State, TerminationReason, TerminationStatus};
use nalgebra::{LU, Matrix6, U6, Vector6};
use thiserror::Error;

use super::state::SolverState;

/// Six equations in six unknowns.
pub trait NewtonProblem {
    /// Where the unknown lives.
    type Point: Clone;

    /// The residual `f` and its Jacobian along the coordinates that [`step`](Self::step) takes.
    fn linearize(&mut self, point: &Self::Point, residual: &mut Vector6<f64>, jacobian: &mut Matrix6<f64>);

    /// The point after the step `delta`.
    fn step(&self, point: &Self::Point, delta: &Vector6<f64>) -> Self::Point;
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonOptions {
    /// A full step whose six numbers are all smaller ends the iteration. Newton's error after it is about its
    /// square, so 3e-8 leaves nothing above rounding.
    pub step_tolerance: f64,
    /// Longest step, in the units of the point; longer ones are shortened.
    pub longest_step: f64,
    /// Iterations after which the search is given up.
    pub max_iterations: u64,
}

impl Default for NewtonOptions {
    fn default() -> Self {
        Self { step_tolerance: 3e-8, longest_step: 1.0, max_iterations: 50 }
    }
}

/// A root, and how it was reached.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NewtonSolution<P> {
    /// The root.
    pub point: P,
    /// Newton steps taken.
    pub iterations: u64,
    /// Determinant of the last Jacobian; its sign tells the two sides of a singularity apart.
    pub determinant: f64,
}

/// Why no root was reached.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum NewtonError {
    /// The iterations were used up or no step reduces the residual.
    #[error("no convergence after {iterations} iterations: residual {residual:.3e}, last step {step:.3e}")]
    NoConvergence {
        /// Steps taken.
        iterations: u64,
        /// Euclidean length of the residual at the end.
        residual: f64,
        /// Largest number of the last step.
        step: f64,
        /// The residual at the end.
        residuals: Vector6<f64>,
    },
    /// The Jacobian cannot be solved with.
    #[error("the Jacobian is singular after {iterations} iterations (pivot ratio {pivot_ratio:.1e})")]
    Singular {
        /// Steps taken.
        iterations: u64,
        /// Smallest over largest pivot of its LU decomposition.
        pivot_ratio: f64,
    },
    /// A residual or Jacobian entry is NaN or infinite.
    #[error("the equations are not finite numbers after {iterations} iterations")]
    NotFinite {
        /// Steps taken.
        iterations: u64,
    },
}

/// The solver; see the module's page.
#[derive(Clone, Debug)]
pub(super) struct Newton {
    options: NewtonOptions,
    residual: Vector6<f64>,
    jacobian: Matrix6<f64>,
    last_step: f64,
    determinant: f64,
    pivot_ratio: f64,
    failure: Option<Failure>,
}

#[derive(Clone, Copy, Debug)]
enum Failure {
    Singular,
    NotFinite,
    Stalled,
}

const SINGULAR: f64 = 1e-13;
const HALVINGS: u32 = 20;

impl Newton {
    /// A solver with these options.
    pub(super) fn new(options: NewtonOptions) -> Self {
        Self {
            options,
            residual: Vector6::zeros(),
            jacobian: Matrix6::zeros(),
            last_step: f64::INFINITY,
            determinant: 0.0,
            pivot_ratio: 0.0,
            failure: None,
        }
    }

    /// The step `-J⁻¹ f`, or `None` where `J` is singular or not finite.
    fn full_step(&mut self) -> Option<Vector6<f64>> {
        let lu: LU<f64, U6, U6> = self.jacobian.lu();
        let factors = lu.lu_internal();
        let (mut small, mut large) = (f64::INFINITY, 0.0_f64);
        for k in 0..6 {
            let pivot = factors[(k, k)].abs();
            small = small.min(pivot);
            large = large.max(pivot);
        }
        self.pivot_ratio = small / large;
        self.determinant = lu.determinant();
        if !(self.pivot_ratio > SINGULAR) {
            self.failure = Some(if large.is_finite() { Failure::Singular } else { Failure::NotFinite });
            return None;
        }
        lu.solve(&-self.residual)
    }
}

impl<O: NewtonProblem> Solver<O, SolverState<O::Point>> for Newton {
    fn name(&self) -> &str {
        "Newton, LU, six unknowns"
    }

    fn init(
        &mut self,
        problem: &mut Problem<O>,
        mut state: SolverState<O::Point>,
    ) -> Result<(SolverState<O::Point>, Option<KV>), argmin::core::Error> {
        if let (Some(problem), Some(point)) = (problem.problem.as_mut(), state.param.as_ref()) {
            problem.linearize(point, &mut self.residual, &mut self.jacobian);
            state.cost = self.residual.norm();
        }
        Ok((state, None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<O>,
        mut state: SolverState<O::Point>,
    ) -> Result<(SolverState<O::Point>, Option<KV>), argmin::core::Error> {
        let (Some(problem), Some(point)) = (problem.problem.as_mut(), state.param.take()) else {
            return Err(argmin::core::Error::msg("the solver was started without a point"));
        };
        if !state.cost.is_finite() {
            self.failure = Some(Failure::NotFinite);
        }
        let step = if self.failure.is_none() { self.full_step() } else { None };
        let Some(mut step) = step else {
            state.param = Some(point);
            return Ok((state.stop(TerminationReason::SolverExit("failed".into())), None));
        };
        let mut length = step.amax();
        if length < self.options.step_tolerance {
            self.last_step = length;
            state.param = Some(problem.step(&point, &step));
            return Ok((state.stop(TerminationReason::SolverConverged), None));
        }
        if length > self.options.longest_step {
            step *= self.options.longest_step / length;
            length = self.options.longest_step;
        }
        let before = state.cost;
        for _ in 0..HALVINGS {
            let trial = problem.step(&point, &step);
            problem.linearize(&trial, &mut self.residual, &mut self.jacobian);
            let after = self.residual.norm();
            if after < before || (after <= before && length < 1e-6) {
                self.last_step = length;
                state.param = Some(trial);
                state.cost = after;
                return Ok((state, None));
            }
            step *= 0.5;
            length *= 0.5;
        }
        self.failure = Some(Failure::Stalled);
        problem.linearize(&point, &mut self.residual, &mut self.jacobian);
        state.param = Some(point);
        Ok((state.stop(TerminationReason::SolverExit("stalled".into())), None))
    }

    fn terminate(&mut self, _state: &SolverState<O::Point>) -> TerminationStatus {
        TerminationStatus::NotTerminated
    }
}

/// Finds a root near `start`.
///
/// # Errors
/// [`NewtonError`] unless the iteration converged; the result is never a point that only ran out of iterations.
pub fn newton<O: NewtonProblem>(
    problem: O,
    start: O::Point,
    options: NewtonOptions,
) -> Result<NewtonSolution<O::Point>, NewtonError> {
    let run = Executor::new(problem, Newton::new(options))
        .configure(|state: SolverState<O::Point>| state.started(start, options.max_iterations))
        .timer(false)
        .ctrlc(false)
        .run();
    // The solver reports its failures through its own fields; argmin adds only "started without a point",
    // which `started` above excludes.
    let Ok(run) = run else { return Err(NewtonError::NotFinite { iterations: 0 }) };
    let (solver, mut state) = (run.solver, run.state);
    let iterations = state.get_iter();
    let converged = matches!(state.get_termination_reason(), Some(TerminationReason::SolverConverged));
    match (converged, solver.failure, state.param.take()) {
        (true, None, Some(point)) => Ok(NewtonSolution { point, iterations, determinant: solver.determinant }),
        (_, Some(Failure::Singular), _) => Err(NewtonError::Singular { iterations, pivot_ratio: solver.pivot_ratio }),
        (_, Some(Failure::NotFinite), _) => Err(NewtonError::NotFinite { iterations }),
        _ => Err(NewtonError::NoConvergence {
            iterations,
            residual: solver.residual.norm(),
            step: solver.last_step,
            residuals: solver.residual,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `x_i² = target_i`, each on its own.
    struct Squares(Vector6<f64>);

    impl NewtonProblem for Squares {
        type Point = Vector6<f64>;
        fn linearize(&mut self, x: &Vector6<f64>, r: &mut Vector6<f64>, j: &mut Matrix6<f64>) {
            *r = x.component_mul(x) - self.0;
            *j = Matrix6::from_diagonal(&(2.0 * x));
        }
        fn step(&self, x: &Vector6<f64>, d: &Vector6<f64>) -> Vector6<f64> {
            x + d
        }
    }

    #[test]
    fn a_root_is_found_to_rounding() {
        let target = Vector6::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0);
        let root = newton(Squares(target), Vector6::repeat(1.5), NewtonOptions::default()).unwrap();
        assert!((root.point - target.map(f64::sqrt)).amax() < 1e-14);
        assert!(root.iterations <= 8 && root.determinant > 0.0);
    }

    #[test]
    fn what_did_not_converge_is_an_error_with_numbers() {
        let no_root = newton(Squares(Vector6::repeat(-1.0)), Vector6::repeat(0.7), NewtonOptions::default());
        assert!(
            matches!(no_root, Err(NewtonError::NoConvergence { residual, .. }) if residual >= 1.0)
                || matches!(no_root, Err(NewtonError::Singular { .. })),
            "{no_root:?}"
        );
        let flat = newton(Squares(Vector6::repeat(1.0)), Vector6::zeros(), NewtonOptions::default());
        assert!(matches!(flat, Err(NewtonError::Singular { .. })), "{flat:?}");
        let nan = newton(Squares(Vector6::repeat(f64::NAN)), Vector6::repeat(1.0), NewtonOptions::default());
        assert!(matches!(nan, Err(NewtonError::NotFinite { .. })), "{nan:?}");
    }
}
