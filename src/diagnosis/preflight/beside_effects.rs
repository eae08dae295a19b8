//! Readings compared with effects in the model, where a strong effect hides from the fit of the parameters alone which way of
//! reading is right.

use std::sync::Arc;

use crate::diagnosis::answer::result::{Diagnosis, Misread, Verdict};
use crate::diagnosis::preflight::compare::{misread_as, near_misses};
use crate::diagnosis::preflight::reading::Reading;
use crate::diagnosis::preflight::trial::Trial;
use crate::diagnosis::question::Question;
use crate::identification::ErrorSummary;
use crate::measurement::{Dataset, MeasurementModel, Noise, PoseMeasurement};

/// Residuals this many times the stated noise are not explained by the names that were found.
const ABOVE: f64 = 2.5;
/// A reading must make what is left this many times smaller, and leave at most this many times the noise.
const BETTER: f64 = 2.0;
/// The least part of the noise that is left beside the parameters.
const LEAST: f64 = 0.6;
/// One of so many rows may be left out.
const MOST_OUT: usize = 10;
/// Readings for which effects are looked for.
const MOST: usize = 7;

/// What is left over the noise that is stated, of positions or angles, whichever is more.
fn left(after: &ErrorSummary, noise: &Noise) -> f64 {
    let over = |v: Option<f64>, sigma: f64| v.map_or(0.0, |v| v / (3.0_f64.sqrt() * sigma));
    over(after.position, noise.position).max(over(after.rotation, noise.rotation))
}

/// How the file should have been read, if effects explain it so much better when it is read otherwise; `answer` is what a
/// search says of a question.
pub(crate) fn misread_beside_effects(
    question: &Question<'_>,
    found: &Diagnosis,
    answer: impl Fn(&Question<'_>) -> Option<Diagnosis>,
) -> Option<Misread> {
    let noise = &question.data.noise;
    let as_stated = left(&found.after, noise);
    let suspicious = as_stated > ABOVE || found.causes.iter().any(|c| !c.plausible);
    // What is left is never much less than the noise, so that there may be nothing to gain.
    if !noise.known || !suspicious || as_stated < BETTER * LEAST {
        return None;
    }
    let trial = Trial::new(question.mechanism, question.data, &question.convention)?;
    let tried = near_misses(&trial, MOST).into_iter().filter_map(|reading| {
        let data = read_otherwise(question, &trial, &reading)?;
        let other = answer(&Question { data: &data, ..question.clone() })?;
        // Few rows are fitted by anything.
        let fair = |d: &Diagnosis| d.outlier_rows.len() <= found.outlier_rows.len().max(d.samples / MOST_OUT);
        (other.verdict != Verdict::Undecided && fair(&other)).then(|| (left(&other.after, noise), reading))
    });
    let mut tried: Vec<(f64, Reading)> = tried.collect();
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (best, _) = tried.first()?;
    let best = *best;
    if !(best * BETTER < as_stated && best < ABOVE) {
        return None;
    }
    tried.retain(|(left, _)| *left < best.max(1.0) * 1.2);
    let readings: Vec<Reading> = tried.into_iter().map(|(_, reading)| reading).collect();
    misread_as(&trial, &readings, as_stated / best)
}

/// The data under a reading; `None` if their poses are not measured in full.
fn read_otherwise(question: &Question<'_>, trial: &Trial<'_>, reading: &Reading) -> Option<Dataset> {
    let (data, noise) = (question.data, question.data.noise);
    let (mut samples, mut poses) = (Vec::new(), Vec::new());
    for (k, sample) in data.iter().enumerate() {
        let (model, index) = data.reading(k);
        model.coordinates(index)?;
        let Some(pose) = trial.table.measured(reading, k) else { continue };
        let mut sample = sample.clone();
        sample.joints = trial.table.joints(reading, k);
        samples.push(sample);
        poses.push(pose);
    }
    let model: Arc<dyn MeasurementModel> =
        Arc::new(PoseMeasurement::full(question.convention, &poses, noise.position, noise.rotation));
    Some(Dataset::new(samples, model, noise))
}
