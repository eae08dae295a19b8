//! Where joints count from that count backwards, by points that were measured alone: these do not say what a joint is asked for,
//! so that the zeros are fitted to the points to which the joints lead.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::diagnosis::preflight::reading::Reading;
use crate::diagnosis::preflight::regression::median;
use crate::diagnosis::preflight::table::SeenKind;
use crate::diagnosis::preflight::trial::Trial;
use crate::mechanism::characteristic_length;
use crate::solve::svd;

/// Steps of the fit.
const STEPS: usize = 6;
/// Difference, part of the size (or of a radian).
const DIFFERENCE: f64 = 1e-5;
/// A step that changes less than this part of the size ends the fit.
const SETTLED: f64 = 1e-7;

/// The reading with the zeros of its backward joints fitted, where points were measured alone.
pub(crate) fn with_zeros(trial: &Trial<'_>, reading: Reading) -> Reading {
    let backward: Vec<usize> = (0..reading.joints.reversed.len()).filter(|k| reading.joints.reversed[*k]).collect();
    if trial.table.kind != SeenKind::Point || backward.is_empty() {
        return reading;
    }
    let size = characteristic_length(trial.mechanism);
    let mut best = reading;
    let Some(mut left) = misses(trial, &best) else { return best };
    for _ in 0..STEPS {
        let Some(step) = step(trial, &best, &backward, &left, DIFFERENCE * size) else { break };
        let mut next = best.clone();
        backward.iter().zip(step.iter()).for_each(|(k, d)| next.joints.zero[*k] += d);
        let Some(misses) = misses(trial, &next) else { break };
        if typical(&misses) >= typical(&left) {
            break;
        }
        (best, left) = (next, misses);
        if step.amax() < SETTLED * size {
            break;
        }
    }
    best
}

/// The step of the zeros that takes the misses of all points away as far as it can.
fn step(
    trial: &Trial<'_>,
    reading: &Reading,
    backward: &[usize],
    left: &[Option<Vector3<f64>>],
    by: f64,
) -> Option<DVector<f64>> {
    let mut moved = Vec::new();
    for k in backward {
        let mut other = reading.clone();
        other.joints.zero[*k] += by;
        moved.push(misses(trial, &other)?);
    }
    let rows: Vec<usize> =
        (0..left.len()).filter(|i| left[*i].is_some() && moved.iter().all(|m| m[*i].is_some())).collect();
    let value = |of: &[Option<Vector3<f64>>], i: usize| of[rows[i / 3]].map_or(0.0, |v| v[i % 3]);
    let r = DVector::from_fn(3 * rows.len(), |i, _| value(left, i));
    let j = DMatrix::from_fn(r.len(), backward.len(), |i, k| (value(&moved[k], i) - value(left, i)) / by);
    svd(j, true, true).solve(&-r, 1e-9).ok()
}

/// What the points miss of those to which the joints lead, m; `None` where most rows lead nowhere.
fn misses(trial: &Trial<'_>, reading: &Reading) -> Option<Vec<Option<Vector3<f64>>>> {
    let commanded = trial.table.commanded(trial.mechanism, reading, &trial.few);
    let miss = |(row, pose): (&usize, Option<crate::pose::Pose>)| {
        let point = trial.table.point(reading, *row)?;
        Some(point.position - pose?.place(&point.place))
    };
    let all: Vec<Option<Vector3<f64>>> = trial.few.iter().zip(commanded).map(miss).collect();
    (2 * all.iter().flatten().count() > all.len()).then_some(all)
}

/// The median distance.
fn typical(misses: &[Option<Vector3<f64>>]) -> f64 {
    median(misses.iter().map(|v| v.map_or(f64::INFINITY, |v| v.norm())).collect())
}
