//! Errors on rows that were not fitted.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use rayon::prelude::*;

use crate::identification::error::IdentifyError;
use crate::identification::estimators::fit::Fit;
use crate::identification::estimators::identifiers::Identifier;
use crate::identification::judgement::model_errors::{ErrorSummary, ModelErrors, errors_at};
use crate::identification::problem::calibration_problem::CalibrationProblem;
use crate::identification::problem::start::sample_error;
use crate::measurement::Dataset;
use crate::mechanism::ForwardQuery;
use crate::pose::Pose;

/// Which rows are held out.
#[derive(Clone, Debug)]
pub enum Holdout {
    /// Each sample once, in this many folds.
    Folds(usize),
    /// A random part of the samples, 0 to 1.
    Fraction(f64),
    /// Other data, in the frames of the calibrated model.
    Data(Box<Dataset>),
    /// None.
    None,
}

/// Errors on samples that were not fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct HeldOut {
    /// Root of the mean square over those samples.
    pub rms: ErrorSummary,
    /// Samples that were predicted.
    pub samples: usize,
}

/// Estimates without the held-out samples, each time from the fit of all of them, and predicts them. `None` if there are too
/// few samples for that.
///
/// # Errors
/// [`IdentifyError`] if an estimate fails for another reason than too few rows.
pub(crate) fn held_out(
    identifier: &dyn Identifier,
    problem: &CalibrationProblem<'_>,
    fit: &Fit,
    holdout: &Holdout,
    seed: u64,
) -> Result<Option<HeldOut>, IdentifyError> {
    let n = problem.data().len();
    let Some(folds) = folds(holdout, n, seed) else { return Ok(None) };
    let predict = |held: &Vec<usize>| -> Result<ModelErrors, IdentifyError> {
        let mut is_held = vec![false; n];
        held.iter().for_each(|k| is_held[*k] = true);
        let rest: Vec<usize> = (0..n).filter(|k| !is_held[*k]).collect();
        let mut rest = problem.subset(&rest, &fit.values);
        let mut found = identifier.estimate(&mut rest);
        if matches!(found, Err(IdentifyError::NotConverged { .. } | IdentifyError::Solve(_))) {
            // Along a direction that the rest hardly decides the fit of all samples may be a worse start than the drawing.
            rest.begin_at(rest.start());
            found = identifier.estimate(&mut rest);
        }
        let found = found?.values;
        let (c, own) = found.as_slice().split_at(problem.mechanism_parameters());
        let poses = poses_near(problem, held, c)?;
        Ok(errors_at(&poses, own, &problem.data().subset(held)))
    };
    let parts: Result<Vec<ModelErrors>, IdentifyError> = folds.par_iter().map(predict).collect();
    match parts {
        Ok(parts) => {
            let all = ModelErrors { samples: parts.into_iter().flat_map(|p| p.samples).collect() };
            Ok(Some(HeldOut { rms: all.rms(), samples: all.samples.len() }))
        }
        Err(
            IdentifyError::TooFewRows { .. }
            | IdentifyError::NotConverged { .. }
            | IdentifyError::Solve(_)
            | IdentifyError::Empty,
        ) => Ok(None),
        Err(other) => Err(other),
    }
}

/// The positions of the samples of each fold, in random order.
fn folds(holdout: &Holdout, n: usize, seed: u64) -> Option<Vec<Vec<usize>>> {
    let mut order: Vec<usize> = (0..n).collect();
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let folds: Vec<Vec<usize>> = match holdout {
        Holdout::Folds(count) => (0..*count).map(|f| order.iter().copied().skip(f).step_by(*count).collect()).collect(),
        Holdout::Fraction(part) => {
            let held = ((part * n as f64).round() as usize).clamp(1, n.saturating_sub(1).max(1));
            vec![order[..held.min(n)].to_vec()]
        }
        Holdout::Data(_) | Holdout::None => return None,
    };
    Some(folds.into_iter().filter(|f| !f.is_empty()).collect())
}

/// Poses of samples for parameters near those that a problem was last evaluated at.
fn poses_near(problem: &CalibrationProblem<'_>, positions: &[usize], c: &[f64]) -> Result<Vec<Pose>, IdentifyError> {
    let data = problem.data();
    let query = |k: &usize| {
        let sample = data.sample(*k);
        ForwardQuery::new(&sample.joints, &sample.conditions, problem.poses()[*k])
    };
    let queries: Vec<ForwardQuery<'_>> = positions.iter().map(query).collect();
    let found = problem.mechanism().forward_batch(c, &queries);
    found.into_iter().zip(positions).map(|(pose, k)| pose.map_err(|cause| sample_error(data, *k, cause))).collect()
}
