//! The state that argmin hands from iteration to iteration.
//!
//! argmin's `IterState` clones the parameter into a "best so far", counts function calls in a hash map of
//! strings and keeps fields for gradients and Hessians. Forward kinematics takes a microsecond, so this state
//! keeps only what the solvers of this crate use.

use std::collections::HashMap;
use std::sync::LazyLock;
use std::time::Duration;

use argmin::core::{Problem, State, TerminationReason, TerminationStatus};

/// The counts of function calls, which are not kept.
static NO_COUNTS: LazyLock<HashMap<String, u64>> = LazyLock::new(HashMap::new);

/// Iterate, its cost, and why the run ended.
#[derive(Clone, Debug)]
pub(super) struct SolverState<P> {
    pub(super) param: Option<P>,
    pub(super) cost: f64,
    pub(super) max_iterations: u64,
    iterations: u64,
    status: TerminationStatus,
}

impl<P> SolverState<P> {
    pub(super) fn started(mut self, param: P, max_iterations: u64) -> Self {
        self.param = Some(param);
        self.max_iterations = max_iterations;
        self
    }

    pub(super) fn stop(self, reason: TerminationReason) -> Self {
        self.terminate_with(reason)
    }
}

impl<P> State for SolverState<P> {
    type Param = P;
    type Float = f64;

    fn new() -> Self {
        Self {
            param: None,
            cost: f64::INFINITY,
            max_iterations: u64::MAX,
            iterations: 0,
            status: TerminationStatus::NotTerminated,
        }
    }

    fn update(&mut self) {}

    fn get_param(&self) -> Option<&P> {
        self.param.as_ref()
    }

    fn get_best_param(&self) -> Option<&P> {
        self.param.as_ref()
    }

    fn get_max_iters(&self) -> u64 {
        self.max_iterations
    }

    fn increment_iter(&mut self) {
        self.iterations += 1;
    }

    fn get_iter(&self) -> u64 {
        self.iterations
    }

    fn get_cost(&self) -> f64 {
        self.cost
    }

    fn get_best_cost(&self) -> f64 {
        self.cost
    }

    fn get_target_cost(&self) -> f64 {
        f64::NEG_INFINITY
    }

    fn func_counts<O>(&mut self, _problem: &Problem<O>) {}

    fn get_func_counts(&self) -> &HashMap<String, u64> {
        &NO_COUNTS
    }

    fn time(&mut self, _time: Option<Duration>) -> &mut Self {
        self
    }

    fn get_time(&self) -> Option<Duration> {
        None
    }

    fn get_last_best_iter(&self) -> u64 {
        self.iterations
    }

    fn is_best(&self) -> bool {
        true
    }

    fn terminate_with(mut self, reason: TerminationReason) -> Self {
        self.status = TerminationStatus::Terminated(reason);
        self
    }

    fn get_termination_status(&self) -> &TerminationStatus {
        &self.status
    }

    fn get_termination_reason(&self) -> Option<&TerminationReason> {
        match &self.status {
            TerminationStatus::Terminated(reason) => Some(reason),
            TerminationStatus::NotTerminated => None,
        }
    }
}
