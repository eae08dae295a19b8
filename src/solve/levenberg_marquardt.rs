//! Levenberg–Marquardt as an argmin `Solver`; argmin has none of its own.

use argmin::core::{KV, Problem, Solver, TerminationReason};
use nalgebra::{DMatrix, DVector};

use super::least_squares::{Convergence, IterationRecord, KeepsProgress, Progress, SolveError};
use super::linear::{LinearMethod, LinearStep, measure, relative_size, slope, solve_step, usable};
use super::state::SolverState;
use super::{LeastSquaresOptions, LeastSquaresProblem};

/// Damped Gauss–Newton: `min_δ |J δ + r|² + λ |D δ|²` with `D` the lengths of the columns of `J`.
///
/// # Requirements on the problem
/// [`LeastSquaresProblem`]; the residual may have no value away from the start, the step is then shortened.
///
/// # Method
/// A step is accepted if it reduces the cost. With `ρ` = actual over predicted reduction, `λ` is multiplied by
/// `max(1/3, 1 - (2ρ - 1)³)` after an accepted step and by 2, 4, 8, … after rejected ones (Nielsen 1999).
/// With `initial_damping = 0` the first steps are plain Gauss–Newton until one fails. Convergence is only
/// declared on the undamped step, so that a run that creeps under heavy damping does not pass for one that
/// has arrived; the last step is computed by QR wherever the normal equations would lose digits.
///
/// Three things keep it from going astray or stopping early:
/// - `D` remembers longer columns and forgets them slowly. A column that becomes short would otherwise free its
///   unknown to run away (Moré 1978 keeps the longest for good, which stalls after a start with huge columns).
/// - A step across which a column all but vanishes is rejected, even if it reduces the cost: it leads to a
///   plateau where the residual no longer tells that unknown, and no later step would find back.
/// - Near the minimum the cost changes by less than its rounding error, so it cannot rank two points there. A
///   step that leaves the cost as it was and reduces the gradient is accepted too.
pub(super) struct LevenbergMarquardt {
    options: LeastSquaresOptions,
    progress: Progress,
    trial_residual: DVector<f64>,
    trial_jacobian: DMatrix<f64>,
    /// Lengths of the columns of both Jacobians.
    norms: DVector<f64>,
    trial_norms: DVector<f64>,
    scale: DVector<f64>,
    damping: f64,
    growth: f64,
}

const FIRST_DAMPING_AFTER_FAILURE: f64 = 1e-4;
const NO_DAMPING_BELOW: f64 = 1e-14;
const HOPELESS_DAMPING: f64 = 1e30;
const ROUNDING_DAMPING: f64 = 1e-12;
/// The part of a longer column's length that `D` keeps from one step to the next.
const SCALE_MEMORY: f64 = 0.8;
/// A column that one step shortens to less than this part has vanished.
const VANISHED: f64 = 1e-4;
/// Predicted relative reduction of the cost below which its rounding error may hide what a step does.
const FLAT: f64 = 1e-8;
/// Damping above which a flat step that fails at a minimum shows that rounding is all that is left: the
/// curvature that Gauss–Newton neglects asks for a damping about 1.
const HOPELESS_DAMPING_WHERE_FLAT: f64 = 1e3;

impl LevenbergMarquardt {
    /// A solver for a problem of that shape.
    pub(super) fn new(options: LeastSquaresOptions, shape: (usize, usize)) -> Self {
        Self {
            options,
            progress: Progress::new(shape),
            trial_residual: DVector::zeros(shape.0),
            trial_jacobian: DMatrix::zeros(shape.0, shape.1),
            norms: DVector::zeros(shape.1),
            trial_norms: DVector::zeros(shape.1),
            scale: DVector::zeros(shape.1),
            damping: options.initial_damping,
            growth: 2.0,
        }
    }

    /// Whether the trial point is to replace the current one.
    fn improves(&mut self, flat: bool) -> bool {
        let (r, j) = (&self.progress.residual, &self.progress.jacobian);
        let (trial_r, trial_j) = (&self.trial_residual, &self.trial_jacobian);
        let (before, after) = (r.norm(), trial_r.norm());
        if !after.is_finite() || !measure(trial_j, &mut self.trial_norms) {
            return false;
        }
        let (then, now) = (&self.norms, &self.trial_norms);
        let vanished = then.iter().zip(now.iter()).any(|(then, now)| *now < VANISHED * then);
        !vanished
            && (after < before
                || flat && after <= before * (1.0 + FLAT) && slope(trial_j, now, trial_r) < slope(j, then, r))
    }

    /// Makes the trial point the current one; the caller moves the unknowns.
    fn accept(&mut self, step: &LinearStep, damping: f64) {
        std::mem::swap(&mut self.progress.residual, &mut self.trial_residual);
        std::mem::swap(&mut self.progress.jacobian, &mut self.trial_jacobian);
        std::mem::swap(&mut self.norms, &mut self.trial_norms);
        let cost = 0.5 * self.progress.residual.norm_squared();
        self.progress.history.push(IterationRecord { cost, step: step.delta.amax(), damping });
    }

    /// The step without damping. Columns that depend on each other have none; a damping at the level of rounding
    /// then leaves the step along what the rows do determine.
    fn undamped_step(&self, columns: &DVector<f64>) -> Option<LinearStep> {
        let p = &self.progress;
        let step = |damping| solve_step(&p.jacobian, &p.residual, columns, damping, LinearMethod::Qr);
        step(0.0).or_else(|| step(ROUNDING_DAMPING))
    }

    /// Converged if the undamped step is negligible; it is then taken if it helps. `step` is a step with the damping of now.
    fn arrived(
        &mut self,
        problem: &mut impl LeastSquaresProblem,
        x: &mut DVector<f64>,
        columns: &DVector<f64>,
        step: LinearStep,
    ) -> bool {
        let last = if self.damping == 0.0 && step.precise { Some(step) } else { self.undamped_step(columns) };
        let Some(step) = last else { return false };
        let reason = if step.moved <= self.options.gradient_tolerance * self.progress.residual.norm() {
            Convergence::SmallGradient
        } else if relative_size(columns, &step.delta, x) <= self.options.step_tolerance {
            Convergence::SmallStep
        } else {
            return false;
        };
        let trial = &*x + &step.delta;
        let evaluated = problem.linearize(&trial, &mut self.trial_residual, &mut self.trial_jacobian);
        if evaluated.is_ok() && self.improves(true) {
            self.accept(&step, 0.0);
            *x = trial;
        }
        self.progress.convergence = Some(reason);
        true
    }

    /// Where no step helps: whether that is a minimum to rounding, and not heavy damping or a broken Jacobian.
    fn stalled_at_minimum(&self, x: &DVector<f64>, columns: &DVector<f64>) -> bool {
        let p = &self.progress;
        let negligible = FLAT.sqrt() * p.residual.norm();
        match self.undamped_step(columns) {
            Some(step) => step.moved <= negligible || relative_size(columns, &step.delta, x) <= FLAT,
            None => slope(&p.jacobian, &self.norms, &p.residual) <= negligible,
        }
    }
}

impl KeepsProgress for LevenbergMarquardt {
    fn into_progress(self) -> Progress {
        self.progress
    }
}

type State = SolverState<DVector<f64>>;

impl<O: LeastSquaresProblem> Solver<&mut O, State> for LevenbergMarquardt {
    fn name(&self) -> &str {
        "Levenberg-Marquardt"
    }

    fn init(
        &mut self,
        problem: &mut Problem<&mut O>,
        mut state: State,
    ) -> Result<(State, Option<KV>), argmin::core::Error> {
        let (Some(problem), Some(x)) = (problem.problem.as_mut(), state.param.as_ref()) else {
            return Err(argmin::core::Error::msg("the solver was started without a point"));
        };
        let p = &mut self.progress;
        if let Err(cause) = problem.linearize(x, &mut p.residual, &mut p.jacobian) {
            p.failure = Some(SolveError::Start(cause));
            return Ok((state.stop(TerminationReason::SolverExit("no start".into())), None));
        }
        p.initial_cost = 0.5 * p.residual.norm_squared();
        state.cost = p.initial_cost;
        if !p.initial_cost.is_finite() || !measure(&p.jacobian, &mut self.norms) {
            p.failure = Some(SolveError::NotFinite { iterations: 0 });
            return Ok((state.stop(TerminationReason::SolverExit("not finite".into())), None));
        }
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
        let columns = usable(&self.norms);
        self.scale = (&self.scale * SCALE_MEMORY).sup(&columns);
        let norm = self.progress.residual.norm();
        if norm <= self.options.residual_floor {
            self.progress.convergence = Some(Convergence::ExactFit);
            state.param = Some(x);
            return Ok((state.stop(TerminationReason::SolverConverged), None));
        }
        loop {
            // An undamped step does not depend on the scale; the columns' own lengths condition it best.
            let scale = if self.damping > 0.0 { &self.scale } else { &columns };
            let step =
                solve_step(&self.progress.jacobian, &self.progress.residual, scale, self.damping, self.options.linear);
            let Some(step) = step else {
                self.damping = (self.damping * 10.0).max(FIRST_DAMPING_AFTER_FAILURE);
                if self.damping > HOPELESS_DAMPING {
                    let (rows, unknowns) = self.progress.jacobian.shape();
                    let iterations = self.progress.history.len();
                    self.progress.failure = Some(SolveError::Singular { iterations, rows, unknowns });
                    state.param = Some(x);
                    return Ok((state.stop(TerminationReason::SolverExit("singular".into())), None));
                }
                continue;
            };
            // |r|² - |r + Jδ|² = |Jδ|² + 2λ|Dδ|² at the damped minimum.
            let predicted = step.moved.powi(2) + 2.0 * self.damping * scale.component_mul(&step.delta).norm_squared();
            let size = relative_size(&columns, &step.delta, &x);
            let small = step.moved <= self.options.gradient_tolerance * norm || size <= self.options.step_tolerance;
            if small && self.arrived(*problem, &mut x, &columns, step.clone()) {
                state.cost = 0.5 * self.progress.residual.norm_squared();
                state.param = Some(x);
                return Ok((state.stop(TerminationReason::SolverConverged), None));
            }
            let flat = predicted <= FLAT * norm * norm;
            let trial = &x + &step.delta;
            let evaluated = problem.linearize(&trial, &mut self.trial_residual, &mut self.trial_jacobian);
            if evaluated.is_ok() && self.improves(flat) {
                let after = self.trial_residual.norm();
                // Where flat, the reduction is rounding error and the model is as good as exact.
                let ratio = if flat { 1.0 } else { (norm - after) * (norm + after) / predicted };
                self.accept(&step, self.damping);
                self.damping *= (1.0 - (2.0 * ratio.min(1.0) - 1.0).powi(3)).max(1.0 / 3.0);
                if self.damping < NO_DAMPING_BELOW {
                    self.damping = 0.0;
                }
                self.growth = 2.0;
                state.cost = 0.5 * after * after;
                state.param = Some(trial);
                return Ok((state, None));
            }
            let hopeless = self.damping > HOPELESS_DAMPING || size <= f64::EPSILON;
            if hopeless || flat && self.damping > HOPELESS_DAMPING_WHERE_FLAT {
                let minimum = self.stalled_at_minimum(&x, &columns);
                self.progress.convergence = minimum.then_some(Convergence::SmallStep);
                if hopeless || minimum {
                    state.param = Some(x);
                    return Ok((state.stop(TerminationReason::SolverExit("no step helps".into())), None));
                }
            }
            // From the damping that failed and not from the first one: a curved valley needs small ones throughout.
            self.damping = match self.damping {
                0.0 => FIRST_DAMPING_AFTER_FAILURE,
                damping => damping * self.growth,
            };
            self.growth *= 2.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LeastSquaresMethod, least_squares};
    use super::*;
    use crate::solve::EvaluationError;

    /// Rosenbrock's valley as least squares.
    struct Valley;

    impl LeastSquaresProblem for Valley {
        fn shape(&self) -> (usize, usize) {
            (2, 2)
        }
        fn linearize(
            &mut self,
            x: &DVector<f64>,
            r: &mut DVector<f64>,
            j: &mut DMatrix<f64>,
        ) -> Result<(), EvaluationError> {
            r[0] = 10.0 * (x[1] - x[0] * x[0]);
            r[1] = 1.0 - x[0];
            j.copy_from_slice(&[-20.0 * x[0], -1.0, 10.0, 0.0]);
            Ok(())
        }
    }

    #[test]
    fn the_valley_is_walked_by_each_method() {
        for method in [
            LeastSquaresMethod::LevenbergMarquardt,
            LeastSquaresMethod::GaussNewton,
            LeastSquaresMethod::ArgminGaussNewton,
        ] {
            for linear in [LinearMethod::Qr, LinearMethod::NormalThenQr] {
                let options = LeastSquaresOptions { linear, residual_floor: 1e-14, ..LeastSquaresOptions::default() };
                let s = least_squares(&mut Valley, DVector::from_vec(vec![-1.2, 1.0]), method, &options).unwrap();
                assert!((&s.x - DVector::repeat(2, 1.0)).amax() < 1e-9, "{method:?} {linear:?}: {}", s.x);
            }
        }
    }

    #[test]
    fn used_up_iterations_are_an_error() {
        let options = LeastSquaresOptions { max_iterations: 2, initial_damping: 1e3, ..LeastSquaresOptions::default() };
        let start = DVector::from_vec(vec![-1.2, 1.0]);
        let s = least_squares(&mut Valley, start, LeastSquaresMethod::LevenbergMarquardt, &options);
        assert!(matches!(s, Err(SolveError::NoConvergence { iterations: 2, .. })), "{s:?}");
    }
}
