//! The readings of a file side by side, and which one is believed.
//!
//! Under each reading the parameters are fitted to the closure at the measured poses (no forward kinematics, which may not
//! exist for a misread file). A reading costs what it leaves and, by the prior, what it needs of the parameters: two legs of
//! one corner that are exchanged are fitted to the noise by anchors that move by a hand's breadth, which no drawing allows.

use crate::diagnosis::answer::result::{Alternative, Misread};
use crate::diagnosis::preflight::found_frames::worth_finding;
use crate::diagnosis::preflight::in_base::{InBase, Screened};
use crate::diagnosis::preflight::reading::Reading;
use crate::diagnosis::preflight::table::SeenKind;
use crate::diagnosis::preflight::trial::{Score, Trial};
use crate::diagnosis::preflight::zeros::with_zeros;
use crate::identification::Look;
use crate::measurement::{Dataset, Frames};
use crate::mechanism::Mechanism;
use crate::pose::PoseConvention;

/// A reading must make what is left this many times smaller.
const BETTER: f64 = 2.0;
/// The least part of the noise that is left beside the parameters.
const LEAST: f64 = 0.6;
/// A second mistake must make what the first leaves this many times smaller.
const SECOND: f64 = 1.6;
/// Readings that leave up to this many times as much fit as well.
const TIED: f64 = 1.5;
/// Readings of the first look that get a last one.
const LAST: usize = 8;
/// A first look may be this many times too bad.
const FIRST: f64 = 4.0;
/// What the noise leaves, with a margin.
const NOISE: f64 = 4.0;
/// What is left below the noise tells nothing.
const FINE: f64 = 1.0;
/// What is left beside a second mistake, or a wrong order of legs, is at least this.
const HOPELESS: f64 = 12.0;
/// Rows this many times farther than what the noise leaves do not fit.
const FAR: f64 = 4.0;

/// A reading with its score.
type Scored = (Reading, Score);

/// How the file should have been read, if not as it stands; `None` also where nothing tells.
pub(crate) fn preflight(mechanism: &dyn Mechanism, data: &Dataset, convention: &PoseConvention) -> Option<Misread> {
    let trial = Trial::new(mechanism, data, convention)?;
    let at_first = stated(&trial, &trial.few, Look::First);
    // No reading leaves much less than the noise.
    if at_first.as_ref().is_some_and(|s| s.value < BETTER * LEAST * trial.of_noise()) {
        return None;
    }
    let mut found = in_base(&trial, &at_first);
    let fits = |found: &[Scored]| found.iter().any(|(_, s)| s.value < NOISE);
    // Beside a fair fit, what is left is more likely an effect than two mistakes.
    let hopeless = at_first.as_ref().is_none_or(|s| s.value > HOPELESS);
    if hopeless && !fits(&found) {
        found.extend(fitted(&trial, worth_finding(&trial), &at_first, true));
    }
    if found.is_empty() {
        return None;
    }
    let as_stated = stated(&trial, &trial.all, Look::Second);
    let limit = as_stated.as_ref().map_or(f64::INFINITY, |s| s.value);
    found.retain(|(_, score)| score.value.max(FINE) * BETTER < limit);
    answer(&trial, found, as_stated.as_ref())
}

/// The score of the file as it stands: in the base frame or in frames that are found, whichever is better.
fn stated(trial: &Trial<'_>, rows: &[usize], look: Look) -> Option<Score> {
    let reading = trial.stated();
    let regression = trial.regression(&reading, &Frames::default());
    // Zeros that are no convention are not fitted away.
    let drawn = regression.is_some_and(|r| r.stated_from_elsewhere);
    let base = trial.score(&reading, rows, look, &Frames::default(), drawn);
    if base.as_ref().is_some_and(|s| s.value < NOISE) {
        return base;
    }
    let found = trial.frames(&reading, rows).and_then(|(frames, _)| trial.score(&reading, rows, look, &frames, false));
    [base, found].into_iter().flatten().min_by(|a, b| a.value.total_cmp(&b.value))
}

/// Readings in the base frame that fit better than the file as it stands: with one mistake in the poses, or with two if
/// nothing else fits.
fn in_base(trial: &Trial<'_>, at_first: &Option<Score>) -> Vec<Scored> {
    // A single point that was measured does not say which joints its pose asks for, unless the platform cannot turn.
    if trial.table.kind == SeenKind::Point && trial.mechanism.controlled()[3..].contains(&true) {
        return fitted(trial, worth_finding(trial), at_first, false);
    }
    let readings = InBase::new(trial);
    let mut found = fitted(trial, readings.singles(), at_first, false);
    let hopeless = at_first.as_ref().is_none_or(|s| s.value > HOPELESS);
    // Three mistakes at once are no reason not to look for two.
    if hopeless && !found.iter().any(|(r, s)| r.count() <= 2 && s.value < NOISE) {
        found.extend(fitted(trial, readings.pairs(), at_first, false));
    }
    found
}

/// The best of the readings after a first and a last look.
fn fitted(trial: &Trial<'_>, screened: Vec<Screened>, at_first: &Option<Score>, find: bool) -> Vec<Scored> {
    let score = |reading: &Reading, rows: &[usize], look: Look| {
        let frames = if find { trial.frames(reading, rows)?.0 } else { Frames::default() };
        trial.score(reading, rows, look, &frames, false)
    };
    let limit = at_first.as_ref().map_or(f64::INFINITY, |s| s.value) * FIRST / BETTER;
    let mut found: Vec<Scored> = screened
        .into_iter()
        .map(|s| if find { s.reading } else { with_zeros(trial, s.reading) })
        .filter_map(|reading| Some((score(&reading, &trial.few, Look::First)?, reading)))
        .map(|(score, reading)| (reading, score))
        .filter(|(_, score)| score.value < limit)
        .collect();
    found.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    found.truncate(LAST);
    let mut found: Vec<Scored> = found
        .into_iter()
        .filter_map(|(reading, _)| Some((score(&reading, &trial.all, Look::Second)?, reading)))
        .map(|(score, reading)| (reading, score))
        .filter(|(reading, score)| trial.explains(reading, score) && trial.is_commanded(reading, &score.frames))
        .collect();
    found.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    found
}

/// Readings of the base frame that fit the file nearly as well as it stands, the best first: beside a strong effect the right
/// one may be among them.
pub(crate) fn near_misses(trial: &Trial<'_>, most: usize) -> Vec<Reading> {
    let at_first = stated(trial, &trial.few, Look::First);
    let mut found = fitted(trial, InBase::new(trial).singles(), &at_first, false);
    found.retain(|(reading, _)| reading.count() == 1);
    found.into_iter().map(|(reading, _)| reading).take(most).collect()
}

/// The answer that a file is misread as the first of these readings, or just as likely as another, by which it fits `factor`
/// times better.
pub(crate) fn misread_as(trial: &Trial<'_>, readings: &[Reading], factor: f64) -> Option<Misread> {
    let scored: Vec<Scored> = readings
        .iter()
        .filter_map(|r| Some((r.clone(), trial.score(r, &trial.all, Look::Second, &Frames::default(), false)?)))
        .map(|(reading, score)| (reading, Score { value: 1.0, ..score }))
        .collect();
    Some(Misread { factor, ..answer(trial, scored, None)? })
}

/// What a reading leaves, with the price of a second mistake.
fn cost((reading, score): &Scored) -> f64 {
    score.value * SECOND.powi(reading.count() as i32 - 1)
}

/// The best reading with those that fit as well.
fn answer(trial: &Trial<'_>, mut found: Vec<Scored>, as_stated: Option<&Score>) -> Option<Misread> {
    found.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    let mut rest = found.into_iter();
    let (best, score) = rest.next()?;
    let mechanism = trial.mechanism;
    let mut alternatives: Vec<Alternative> = Vec::new();
    for (reading, other) in rest {
        let detail = reading.detail(mechanism);
        let is_new = reading != best && alternatives.iter().all(|a| a.detail != detail);
        if is_new && other.value < TIED * score.value && reading.count() <= best.count() {
            alternatives.push(Alternative { reading: reading.name(), detail });
        }
    }
    let far = |length: &f64| !(*length <= FAR * score.misfit);
    let failing = match as_stated {
        // The share of each row in the deviations from the drawing counts with what the row itself leaves.
        Some(stated) => {
            let share = stated.value.powi(2) - stated.misfit.powi(2);
            stated.lengths.iter().filter(|l| far(&(l.powi(2) + share).sqrt())).count()
        }
        None => trial.all.len(),
    };
    // Of a long file every few rows were looked at.
    let rows_failing = failing * trial.table.len() / trial.all.len().max(1);
    Some(Misread {
        reading: best.name(),
        detail: best.detail(mechanism),
        factor: as_stated.map_or(f64::INFINITY, |s| s.value) / score.value,
        tied_with: alternatives.iter().map(|a| format!("{}: {}", a.reading, a.detail)).collect(),
        alternatives,
        rows_failing,
    })
}
