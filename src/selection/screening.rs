//! Which of very many candidates an exchange looks at.
//!
//! A set that is good for a part of the candidates already tells what a better one needs: each candidate is ranked by
//! what it would do for that set, in one scan of all of them, and the exchanges go on among the best. Of a hundred
//! thousand random poses a few hundred are ever chosen by any start.

use rand::seq::index::sample;

use super::candidates::random_stream;
use super::exchange::improve;
use super::relaxation::relax;
use super::{Problem, SelectionError};
use crate::observability::{FastForm, O1, O3};

/// Lists up to this length are searched as they are.
pub(super) const WHOLE: usize = 10_000;
/// Candidates of the first, quick set.
const DRAWN: usize = 2000;
/// Candidates that are kept, and how many where each costs a decomposition.
const KEPT: usize = 3000;
const KEPT_COSTLY: usize = 1200;
/// Fresh parts that are tried.
const SETTLED: usize = 5;
const STREAM: u64 = 6 << 32;

/// True if a list is so long that a part of it is searched.
pub(super) fn is_long(problem: &Problem<'_>) -> bool {
    problem.candidates.len() > WHOLE.max(4 * problem.count)
}

/// The numbers of a quick set: exchanges among a few candidates drawn at random.
///
/// # Errors
/// [`SelectionError::TooFewCandidates`].
pub(super) fn quick_set(problem: &Problem<'_>) -> Result<Vec<usize>, SelectionError> {
    problem.check()?;
    let mut rng = random_stream(problem.seed, STREAM);
    let drawn = DRAWN.max(2 * problem.count).min(problem.candidates.len());
    let mut numbers = sample(&mut rng, problem.candidates.len(), drawn).into_vec();
    numbers.sort_unstable();
    let few = problem.candidates.only(&numbers);
    let among = Problem { candidates: &few, ..*problem };
    let (_, members) = improve(&among, &among.greedy());
    Ok(members.into_iter().map(|k| numbers[k]).collect())
}

/// Exchanges a set that is best within a part of the candidates for candidates of the whole list, until none is left
/// that would make it better, or until a fresh part around the set has none.
pub(super) fn settle(problem: &Problem<'_>, members: &[usize]) -> (f64, Vec<usize>) {
    match problem.index.fast() {
        FastForm::Determinant | FastForm::Trace(_) => return improve(problem, members),
        FastForm::Extremes(_) | FastForm::HarmonicSum => {}
        // Every candidate costs a decomposition.
        FastForm::None => return (problem.set(members).value(), members.to_vec()),
    }
    let mut best = (problem.set(members).value(), members.to_vec());
    for _ in 0..SETTLED {
        let numbers = shortlist(problem, &best.1);
        let few = problem.candidates.only(&numbers);
        let places: Vec<usize> = best.1.iter().filter_map(|k| numbers.binary_search(k).ok()).collect();
        let (value, found) = improve(&Problem { candidates: &few, ..*problem }, &places);
        if !problem.index.goal().better(value, best.0) {
            break;
        }
        best = (value, found.into_iter().map(|k| numbers[k]).collect());
    }
    best
}

/// The numbers, in order, of the candidates that do most for a set, and of the set itself.
pub(super) fn shortlist(problem: &Problem<'_>, around: &[usize]) -> Vec<usize> {
    let least = 20 * problem.count;
    // Exchanges for these indices also start from the best sets for the volume.
    if matches!(problem.index.fast(), FastForm::Extremes(_) | FastForm::HarmonicSum) {
        let volume = Problem { index: &O1, ..*problem };
        let own = strongest(&problem.set(around).gains(), KEPT_COSTLY.max(least), around.iter().copied());
        return strongest(&volume.set(around).gains(), KEPT_COSTLY.max(least), own);
    }
    strongest(&problem.set(around).gains(), KEPT.max(least), around.iter().copied())
}

/// The numbers of the candidates that have a share in the relaxation over the whole list, for indices of extreme
/// singular values in that of O3.
pub(super) fn support(problem: &Problem<'_>) -> Vec<usize> {
    let index = if matches!(problem.index.fast(), FastForm::Extremes(_)) { &O3 } else { problem.index };
    let fixed = problem.fixed_rows();
    let found = relax(&problem.candidates.pool, index, &fixed, problem.given.len(), problem.count);
    found.map_or_else(Vec::new, |found| found.shares.into_iter().map(|(k, _)| k).collect())
}

/// The numbers of the `kept` largest values, of equal ones the first, and these others, all in order.
pub(super) fn strongest(values: &[f64], kept: usize, others: impl IntoIterator<Item = usize>) -> Vec<usize> {
    let value = |k: usize| if values[k].is_nan() { f64::NEG_INFINITY } else { values[k] };
    let mut order: Vec<usize> = (0..values.len()).collect();
    if kept < order.len() {
        order.select_nth_unstable_by(kept, |a, b| value(*b).total_cmp(&value(*a)).then(a.cmp(b)));
        order.truncate(kept);
    }
    order.extend(others);
    order.sort_unstable();
    order.dedup();
    order
}
