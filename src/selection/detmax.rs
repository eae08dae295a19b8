//! The two algorithms of the paper's section 3.2.

use std::collections::VecDeque;

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::index::sample;

use super::{Choice, Numbered, PoseSelector, Problem, SelectionError, Step};
use crate::observability::PoseSet;

/// Adds the candidate that makes the index best, then removes the member that leaves it best; ends when both are the
/// same.
#[derive(Clone, Copy, Debug)]
pub struct Detmax {
    /// Largest number of iterations.
    pub iterations: usize,
}

impl Default for Detmax {
    fn default() -> Self {
        Self { iterations: 500 }
    }
}

impl PoseSelector for Detmax {
    fn name(&self) -> &str {
        "detmax"
    }

    fn select(&self, problem: &Problem<'_>) -> Result<Choice, SelectionError> {
        self.select_numbered(problem).map(|found| found.choice)
    }

    fn select_numbered(&self, problem: &Problem<'_>) -> Result<Numbered, SelectionError> {
        let mut rng = ChaCha8Rng::seed_from_u64(problem.seed);
        let mut set = problem.set(&problem.start(&mut rng)?);
        let mut trace = vec![set.quick_value()];
        for done in 0..self.iterations {
            (problem.watch)(Step { done, total: self.iterations });
            let Some((added, removed)) = swap(&mut set) else { break };
            trace.push(set.quick_value());
            if removed == added {
                break;
            }
        }
        Ok(problem.choice_of(set.members(), trace))
    }
}

/// Adds the best candidate, then removes the member whose loss is the least; `None` and no change if none is open.
fn swap(set: &mut PoseSet<'_>) -> Option<(usize, usize)> {
    let added = set.best_addition()?.which;
    set.add(added);
    let removed = set.best_removal()?.which;
    Some((added, set.remove(removed)))
}

/// One-point exchange with a tabu list: a removed pose may not return until as many others have been removed as the
/// list is long. The list starts with poses drawn at random; the best set seen is kept.
#[derive(Clone, Copy, Debug)]
pub struct TabuDetmax {
    /// Length of the tabu list; at most a quarter of the candidates are kept out.
    pub length: usize,
    /// Number of iterations.
    pub iterations: usize,
}

impl Default for TabuDetmax {
    fn default() -> Self {
        Self { length: 100, iterations: 400 }
    }
}

impl PoseSelector for TabuDetmax {
    fn name(&self) -> &str {
        "tabu-detmax"
    }

    fn select(&self, problem: &Problem<'_>) -> Result<Choice, SelectionError> {
        self.select_numbered(problem).map(|found| found.choice)
    }

    fn select_numbered(&self, problem: &Problem<'_>) -> Result<Numbered, SelectionError> {
        let mut rng = ChaCha8Rng::seed_from_u64(problem.seed);
        let start = problem.start(&mut rng)?;
        let mut set = problem.set(&start);
        let others: Vec<usize> = (0..problem.candidates.len()).filter(|k| !start.contains(k)).collect();
        let length = self.length.min(others.len() / 4);
        let mut tabu: VecDeque<usize> = sample(&mut rng, others.len(), length).iter().map(|k| others[k]).collect();
        tabu.iter().for_each(|k| set.close(*k));
        let mut best = (set.quick_value(), start);
        let mut trace = Vec::with_capacity(self.iterations + 1);
        trace.push(best.0);
        for done in 0..self.iterations {
            (problem.watch)(Step { done, total: self.iterations });
            let Some((_, removed)) = swap(&mut set) else { break };
            set.close(removed);
            tabu.push_back(removed);
            if tabu.len() > length
                && let Some(free) = tabu.pop_front()
            {
                set.reopen(free);
            }
            let value = set.quick_value();
            trace.push(value);
            if set.better(value, best.0) {
                best = (value, set.members().to_vec());
            }
        }
        Ok(problem.choice_of(&best.1, trace))
    }
}
