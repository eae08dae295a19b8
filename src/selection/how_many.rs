//! From which number of poses on measuring does not pay any more.

use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::job::{ChosenSet, SelectionTask, select_among};
use super::{Candidates, PoseSelector, SelectionError, Step};
use crate::units::{show_angle, show_length};

/// An accuracy of the calibrated pose, RMS over the targets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Requirement {
    /// Length of the position error, m.
    pub position: Option<f64>,
    /// Length of the rotation error, rad.
    pub rotation: Option<f64>,
}

impl Requirement {
    /// True if a report is predicted to meet it.
    pub fn met_by(&self, report: &ChosenSet) -> bool {
        let Some(forecast) = &report.forecast else { return false };
        self.position.is_none_or(|p| forecast.error.position_rms <= p)
            && self.rotation.is_none_or(|r| forecast.error.rotation_rms <= r)
    }
}

/// Largest number of poses that a requirement may need.
pub const MOST_POSES: usize = 200;

/// Choices for each number of poses, in order. Numbers that are too small for the index are left out.
///
/// # Errors
/// [`SelectionError`] of the largest number.
pub fn how_many(
    plan: &SelectionTask<'_>,
    selector: &dyn PoseSelector,
    candidates: &Candidates,
    numbers: impl IntoIterator<Item = usize>,
    with_bound: bool,
) -> Result<Vec<ChosenSet>, SelectionError> {
    let numbers: Vec<usize> = numbers.into_iter().collect();
    let total = numbers.len();
    let done = AtomicUsize::new(0);
    let silent = |_: Step| {};
    let quiet = SelectionTask { watch: &silent, ..*plan };
    let found: Vec<Result<ChosenSet, SelectionError>> = numbers
        .into_par_iter()
        .map(|n| {
            let report = select_among(&quiet, selector, candidates, n, with_bound);
            (plan.watch)(Step { done: done.fetch_add(1, Ordering::Relaxed), total });
            report
        })
        .collect();
    let mut reports = Vec::new();
    let mut refusal = None;
    for result in found {
        match result {
            Ok(report) => reports.push(report),
            Err(cause @ (SelectionError::TooFewPoses { .. } | SelectionError::NothingToSelect { .. })) => {
                refusal = Some(cause);
            }
            // A short list ends the table.
            Err(cause @ SelectionError::TooFewCandidates { .. }) => refusal = Some(cause),
            Err(cause) => return Err(cause),
        }
    }
    match refusal {
        Some(cause) if reports.is_empty() => Err(cause),
        _ => Ok(reports),
    }
}

/// The smallest number of poses whose choice is predicted to meet a requirement.
///
/// # Errors
/// [`SelectionError::Requirement`] if 200 poses, or all candidates, do not.
pub fn smallest_number(
    plan: &SelectionTask<'_>,
    selector: &dyn PoseSelector,
    candidates: &Candidates,
    requirement: &Requirement,
) -> Result<usize, SelectionError> {
    const AT_ONCE: usize = 8;
    let most = MOST_POSES.min(candidates.len() + plan.given.len());
    let ends = how_many(plan, selector, candidates, [most], false)?;
    let Some(last) = ends.last().filter(|r| r.forecast.is_some()) else { return Err(SelectionError::NoNoise) };
    if !requirement.met_by(last) {
        return Err(refused(last, requirement));
    }
    let least = plan.given.len() + 1;
    for first in (least..=most).step_by(AT_ONCE) {
        let numbers = first..(first + AT_ONCE).min(most + 1);
        let reports = match how_many(plan, selector, candidates, numbers, false) {
            Err(SelectionError::TooFewPoses { .. }) => continue,
            other => other?,
        };
        if let Some(enough) = reports.iter().find(|r| requirement.met_by(r)) {
            return Ok(enough.poses.len());
        }
    }
    Ok(most)
}

fn refused(last: &ChosenSet, requirement: &Requirement) -> SelectionError {
    let error = last.forecast.as_ref().map(|f| f.error);
    let (position, rotation) = error.map_or((f64::NAN, f64::NAN), |e| (e.position_rms, e.rotation_rms));
    let ratio = |found: f64, wanted: Option<f64>| wanted.map_or(0.0, |w| found / w);
    let short = ratio(position, requirement.position).max(ratio(rotation, requirement.rotation));
    let prior = last.forecast.as_ref().is_some_and(|f| f.prior);
    let limit = if prior { ", choose a larger workspace" } else { "" };
    SelectionError::Requirement {
        poses: last.poses.len(),
        position: show_length(position),
        rotation: show_angle(rotation),
        advice: format!("measure about {short:.1} times as precisely{limit}, or relax the requirement"),
    }
}
