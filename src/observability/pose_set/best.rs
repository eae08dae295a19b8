//! The largest of many scores.

use crate::observability::kernel::{LANES, Lanes};

/// Scores closer than this are a tie; the candidate with the smaller index wins.
const TIE: f64 = 1e-12;

/// The best candidate or member by score; larger scores are better.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Best {
    /// Candidate, or position among the members.
    pub which: usize,
    /// Its score: comparable only within one scan.
    pub score: f64,
}

/// The largest score; of ties the smallest index.
pub(super) fn best_of(scores: impl IntoIterator<Item = f64>) -> Option<Best> {
    scores.into_iter().enumerate().fold(None, better_of)
}

/// The best of the open candidates, batch by batch: most batches hold nothing above the best so far.
pub(super) fn best_open(scores: &[Lanes], open: &[Lanes]) -> Option<Best> {
    let mut best: Option<Best> = None;
    for (batch, (scores, open)) in scores.iter().zip(open).enumerate() {
        if best.is_none_or(|best| scores.iter().fold(false, |any, score| any | (*score > best.score))) {
            let lanes = (0..LANES).filter(|lane| open[*lane] != 0.0);
            best = lanes.map(|lane| (batch * LANES + lane, scores[lane])).fold(best, better_of);
        }
    }
    best
}

fn better_of(best: Option<Best>, (which, score): (usize, f64)) -> Option<Best> {
    let slack = |b: Best| if b.score.is_finite() { TIE * b.score.abs() } else { 0.0 };
    let better = best.is_none_or(|b| score > b.score + slack(b)) && !score.is_nan();
    if better { Some(Best { which, score }) } else { best }
}
