//! Levenberg–Marquardt as an argmin `Solver`; argmin has none of its own.

use argmin::core::{KV, Problem, Solver, TerminationReason};
use nalgebra::{DMatrix, DVector};

use super::least_squares::{Convergence, IterationRecord, KeepsProgress, Progress, SolveError};
use super::linear::{LinearMethod, column_norms, solve_step};
use super::state::SolverState;
use super::{LeastSquaresOptions, LeastSquaresProblem};

/// Damped Gauss–Newton: $\min_δ |J δ + r|^2 + λ |D δ|^2$ with $D$ the lengths of the columns of $J$.
///
/// # Requirements on the problem
/// [`LeastSquaresProblem`]; the residual may have no value away from the start, the step is then shortened.
///
/// # Method
/// A step is accepted if it reduces the cost. With $ρ$ = actual over predicted reduction, $λ$ is multiplied by
/// $\max(1/3, 1 - (2ρ - 1)^3)$ after an accepted step and by 2, 4, 8, … after rejected ones (Nielsen 1999).
/// With `initial_damping = 0` the first steps are plain Gauss–Newton until one fails. Convergence is only
/// declared on the undamped step, so that a run that creeps under heavy damping does not pass for one that
/// has arrived; the last step is computed by QR.
pub struct LevenbergMarquardt {
    options: LeastSquaresOptions,
    progress: Progress,
    trial_residual: DVector<f64>,
    trial_jacobian: DMatrix<f64>,
    damping: f64,
    growth: f64,
}

const FIRST_DAMPING_AFTER_FAILURE: f64 = 1e-4;
const NO_DAMPING_BELOW: f64 = 1e-14;
const HOPELESS_DAMPING: f64 = 1e30;

impl LevenbergMarquardt {
    /// A solver for a problem of that shape.
    pub fn new(options: LeastSquaresOptions, shape: (usize, usize)) -> Self {
        Self {
            options,
            progress: Progress::new(shape),
            trial_residual: DVector::zeros(shape.0),
            trial_jacobian: DMatrix::zeros(shape.0, shape.1),
            damping: options.initial_damping,
            growth: 2.0,
        }
    }

    /// Converged if the undamped step is negligible; it is then taken if it helps.
    fn arrived(&mut self, problem: &mut impl LeastSquaresProblem, x: &mut DVector<f64>, scale: &DVector<f64>) -> bool {
        let p = &mut self.progress;
        let norm = p.residual.norm();
        if norm <= self.options.residual_floor {
            p.convergence = Some(Convergence::ExactFit);
            return true;
        }
        let Some(step) = solve_step(&p.jacobian, &p.residual, scale, 0.0, LinearMethod::Qr) else { return false };
        let size = scale.component_mul(&step.delta).norm() / scale.component_mul(x).norm().max(f64::MIN_POSITIVE);
        let reason = if step.moved <= self.options.gradient_tolerance * norm {
            Convergence::SmallGradient
        } else if size <= self.options.step_tolerance {
            Convergence::SmallStep
        } else {
            return false;
        };
        let trial = &*x + &step.delta;
        let evaluated = problem.linearize(&trial, &mut self.trial_residual, &mut self.trial_jacobian);
        if evaluated.is_ok() && self.trial_residual.norm() <= norm {
            std::mem::swap(&mut p.residual, &mut self.trial_residual);
            std::mem::swap(&mut p.jacobian, &mut self.trial_jacobian);
            p.history.push(IterationRecord {
                cost: 0.5 * p.residual.norm_squared(),
                step: step.delta.amax(),
                damping: 0.0,
            });
            *x = trial;
        }
        p.convergence = Some(reason);
        true
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
        if !p.initial_cost.is_finite() || p.jacobian.iter().any(|v| !v.is_finite()) {
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
        let scale = column_norms(&self.progress.jacobian);
        let norm = self.progress.residual.norm();
        if norm <= self.options.residual_floor {
            self.progress.convergence = Some(Convergence::ExactFit);
            state.param = Some(x);
            return Ok((state.stop(TerminationReason::SolverConverged), None));
        }
        loop {
            let step =
                solve_step(&self.progress.jacobian, &self.progress.residual, &scale, self.damping, self.options.linear);
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
            let size = scale.component_mul(&step.delta).norm() / scale.component_mul(&x).norm().max(f64::MIN_POSITIVE);
            let small = step.moved <= self.options.gradient_tolerance * norm || size <= self.options.step_tolerance;
            if small && self.arrived(*problem, &mut x, &scale) {
                state.cost = 0.5 * self.progress.residual.norm_squared();
                state.param = Some(x);
                return Ok((state.stop(TerminationReason::SolverConverged), None));
            }
            let trial = &x + &step.delta;
            let evaluated = problem.linearize(&trial, &mut self.trial_residual, &mut self.trial_jacobian);
            let after = self.trial_residual.norm();
            let scaled = scale.component_mul(&step.delta).norm();
            // |r|² - |r + Jδ|² = |Jδ|² + 2λ|Dδ|² at the damped minimum.
            let predicted = step.moved.powi(2) + 2.0 * self.damping * scaled.powi(2);
            let ratio = (norm - after) * (norm + after) / predicted.max(f64::MIN_POSITIVE);
            let finite = after.is_finite() && self.trial_jacobian.iter().all(|v| v.is_finite());
            if evaluated.is_ok() && finite && after < norm {
                self.progress.history.push(IterationRecord {
                    cost: 0.5 * after * after,
                    step: step.delta.amax(),
                    damping: self.damping,
                });
                std::mem::swap(&mut self.progress.residual, &mut self.trial_residual);
                std::mem::swap(&mut self.progress.jacobian, &mut self.trial_jacobian);
                self.damping *= (1.0 - (2.0 * ratio.min(1.0) - 1.0).powi(3)).max(1.0 / 3.0);
                if self.damping < NO_DAMPING_BELOW {
                    self.damping = 0.0;
                }
                self.growth = 2.0;
                state.cost = 0.5 * after * after;
                state.param = Some(trial);
                return Ok((state, None));
            }
            if self.damping > HOPELESS_DAMPING || scaled <= f64::EPSILON * scale.component_mul(&x).norm() {
                // No step, however short, reduces the cost: a minimum to rounding, or a broken Jacobian.
                if step.moved <= 1e-6 * norm || after <= norm * (1.0 + 1e-12) {
                    self.progress.convergence = Some(Convergence::SmallStep);
                }
                state.param = Some(x);
                return Ok((state.stop(TerminationReason::SolverExit("no step helps".into())), None));
            }
            self.damping = (self.damping * self.growth).max(FIRST_DAMPING_AFTER_FAILURE);
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
