//! Multi-start exchange, the default.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand::seq::index::sample;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::candidates::random_stream;
use super::polish::polish;
use super::relaxation::relax;
use super::screening::{is_long, quick_set, settle, shortlist, support};
use super::{Choice, Numbered, PoseSelector, Problem, SelectionError, Step};
use crate::observability::{FastForm, O1, O5, ObservabilityIndex};

/// Exchange of each member for the best candidate until none improves (Cook and Nachtsheim 1980), from the rounded
/// relaxation, from sets that are best for smoother indices, and from random sets; then repeated with some members
/// of the best set replaced at random; then every pose is moved freely inside the workspace.
///
/// Of more than 10,000 candidates those take part that would do most for a set that was found quickly; at the end all
/// candidates are looked at once more.
#[derive(Clone, Copy, Debug)]
pub struct Exchange {
    /// Random sets to start from.
    pub starts: usize,
    /// Rounds of replacing members of the best set at random.
    pub rounds: usize,
    /// Whether poses are moved off the candidates at the end.
    pub polish: bool,
}

impl Default for Exchange {
    fn default() -> Self {
        Self { starts: 20, rounds: 40, polish: true }
    }
}

/// Members that a round replaces.
const REPLACED: usize = 4;
/// So many more rounds where the candidates are few of a long list, and rounds are short.
const MORE_ROUNDS: usize = 4;
/// Passes over all members; exchanges end by themselves long before.
const PASSES: usize = 200;

impl PoseSelector for Exchange {
    fn name(&self) -> &str {
        "exchange"
    }

    fn wants_corners(&self) -> bool {
        true
    }

    fn select(&self, problem: &Problem<'_>) -> Result<Choice, SelectionError> {
        self.select_numbered(problem).map(|found| found.choice)
    }

    fn select_numbered(&self, problem: &Problem<'_>) -> Result<Numbered, SelectionError> {
        problem.check()?;
        let found = if is_long(problem) { self.screened(problem)? } else { self.search(problem)? };
        Ok(self.finished(problem, found))
    }
}

/// The best set of a search, and the best value after each of its steps.
struct Searched {
    value: f64,
    members: Vec<usize>,
    trace: Vec<f64>,
}

impl Exchange {
    /// The choice when every candidate takes part in every exchange, however many there are: what the screening of
    /// long lists is measured against.
    ///
    /// # Errors
    /// [`SelectionError::TooFewCandidates`].
    pub fn select_unscreened(&self, problem: &Problem<'_>) -> Result<Choice, SelectionError> {
        problem.check()?;
        Ok(self.finished(problem, self.search(problem)?).choice)
    }

    /// Searches the most promising candidates of a long list, then the rest of it from where that ended.
    fn screened(&self, problem: &Problem<'_>) -> Result<Searched, SelectionError> {
        let mut numbers = shortlist(problem, &quick_set(problem)?);
        numbers.extend(support(problem));
        numbers.sort_unstable();
        numbers.dedup();
        let few = problem.candidates.only(&numbers);
        let longer = Self { rounds: MORE_ROUNDS * self.rounds, ..*self };
        let mut found = longer.search(&Problem { candidates: &few, ..*problem })?;
        found.members.iter_mut().for_each(|k| *k = numbers[*k]);
        let (value, members) = settle(problem, &found.members);
        if problem.index.goal().better(value, found.value) {
            (found.value, found.members) = (value, members);
        }
        found.trace.push(found.value);
        Ok(found)
    }

    fn finished(&self, problem: &Problem<'_>, found: Searched) -> Numbered {
        let mut numbered = problem.choice_of(&found.members, found.trace);
        if self.polish {
            let Numbered { choice, numbers } = &mut numbered;
            choice.trace.push(polish(problem, &mut choice.poses, numbers));
            choice.iterations += 1;
        }
        numbered
    }

    /// Exchanges from many starts among all candidates of a problem.
    fn search(&self, problem: &Problem<'_>) -> Result<Searched, SelectionError> {
        // Indices whose scans need a decomposition get fewer of them.
        let costly = matches!(problem.index.fast(), FastForm::Extremes(_) | FastForm::HarmonicSum | FastForm::None);
        let (starts, rounds) =
            if costly { (self.starts.div_ceil(3), self.rounds / 4) } else { (self.starts, self.rounds) };
        let mut sets = self.informed_starts(problem);
        sets.extend(
            (0..starts as u64)
                .map(|stream| problem.start(&mut random_stream(problem.seed, stream)))
                .collect::<Result<Vec<_>, _>>()?,
        );
        sets.sort_unstable();
        sets.dedup();
        let done = AtomicUsize::new(0);
        let total = sets.len() + rounds;
        let improved = |members: Vec<usize>| {
            let found = improve(problem, &members);
            (problem.watch)(Step { done: done.fetch_add(1, Ordering::Relaxed), total });
            found
        };
        let found: Vec<(f64, Vec<usize>)> = sets.into_par_iter().map(improved).collect();
        let goal = problem.index.goal();
        let mut trace = Vec::new();
        let mut best: Option<(f64, Vec<usize>)> = None;
        for (value, members) in found {
            if best.as_ref().is_none_or(|b| goal.better(value, b.0)) {
                best = Some((value, members));
            }
            trace.extend(best.as_ref().map(|b| b.0));
        }
        let Some(mut best) = best else {
            return Err(SelectionError::TooFewCandidates { wanted: problem.count, found: 0 });
        };
        for round in 0..rounds as u64 {
            let mut rng = random_stream(problem.seed, 1 << 32 | round);
            let (value, members) = improved(shaken(problem, &best.1, &mut rng));
            if goal.better(value, best.0) {
                best = (value, members);
            }
            trace.push(best.0);
        }
        Ok(Searched { value: best.0, members: best.1, trace })
    }

    /// Starts that know something: the heaviest candidates of the relaxation, a greedy set, and for indices on which
    /// exchanges get stuck the best sets for O1 and O5.
    fn informed_starts(&self, problem: &Problem<'_>) -> Vec<Vec<usize>> {
        let mut sets = vec![problem.greedy()];
        let fixed = problem.fixed_rows();
        if let Some(found) = relax(&problem.candidates.pool, problem.index, &fixed, problem.given.len(), problem.count)
        {
            sets.extend(rounded(problem, found.shares));
        }
        if matches!(problem.index.fast(), FastForm::Extremes(_) | FastForm::HarmonicSum) {
            let smoother: [&dyn ObservabilityIndex; 2] = [&O1, &O5];
            for index in smoother {
                let other = Problem { index, ..*problem };
                sets.push(improve(&other, &problem.greedy()).1);
            }
        }
        sets
    }
}

/// The heaviest candidates; a greedy choice fills up what is missing.
fn rounded(problem: &Problem<'_>, mut shares: Vec<(usize, f64)>) -> Option<Vec<usize>> {
    shares.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let members: Vec<usize> = shares.iter().take(problem.count).map(|(k, _)| *k).collect();
    let mut set = problem.set(&members);
    while set.members().len() < problem.count {
        let best = set.best_addition()?;
        set.add(best.which);
    }
    Some(set.members().to_vec())
}

/// The best set with some members replaced at random.
fn shaken(problem: &Problem<'_>, members: &[usize], rng: &mut ChaCha8Rng) -> Vec<usize> {
    let mut members = members.to_vec();
    let replaced = REPLACED.min(members.len());
    for position in sample(rng, members.len(), replaced) {
        let new = rng.random_range(0..problem.candidates.len());
        if !members.contains(&new) {
            members[position] = new;
        }
    }
    members
}

/// Exchanges members for better candidates until none is left.
pub(super) fn improve(problem: &Problem<'_>, members: &[usize]) -> (f64, Vec<usize>) {
    let mut set = problem.set(members);
    for _ in 0..PASSES {
        let mut changed = false;
        for position in 0..members.len() {
            changed |= set.exchange(position);
        }
        if !changed {
            break;
        }
    }
    let mut members = set.members().to_vec();
    members.sort_unstable();
    (set.value(), members)
}
