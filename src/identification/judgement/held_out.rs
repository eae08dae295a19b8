//! Errors on rows that were not fitted.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use rayon::prelude::*;

use crate::identification::error::IdentifyError;
use crate::identification::estimators::identifiers::Identifier;
use crate::identification::judgement::model_errors::{ErrorSummary, ModelErrors, evaluate};
use crate::identification::task::Task;
use crate::measurement::Dataset;

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

/// Identifies without the held-out samples and predicts them. `None` if there are too few samples for that.
///
/// # Errors
/// [`IdentifyError`] if an identification fails for another reason than too few rows.
pub(crate) fn held_out(
    identifier: &dyn Identifier,
    task: &Task<'_>,
    holdout: &Holdout,
    seed: u64,
) -> Result<Option<HeldOut>, IdentifyError> {
    let n = task.data.len();
    let mut order: Vec<usize> = (0..n).collect();
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let folds: Vec<Vec<usize>> = match holdout {
        Holdout::Folds(count) => (0..*count).map(|f| order.iter().copied().skip(f).step_by(*count).collect()).collect(),
        Holdout::Fraction(part) => {
            let held = ((part * n as f64).round() as usize).clamp(1, n.saturating_sub(1).max(1));
            vec![order[..held.min(n)].to_vec()]
        }
        Holdout::Data(_) | Holdout::None => return Ok(None),
    };
    let predict = |held: &Vec<usize>| -> Result<ModelErrors, IdentifyError> {
        let mut is_held = vec![false; n];
        held.iter().for_each(|k| is_held[*k] = true);
        let rest: Vec<usize> = (0..n).filter(|k| !is_held[*k]).collect();
        let fitted = task.data.subset(&rest);
        let found = identifier.identify(&Task { data: &fitted, ..*task })?;
        let mechanism = task.mechanism.with_values(&found.mechanism_values(), task.mechanism.home())?;
        evaluate(mechanism.as_ref(), &found.own_values(), &task.data.subset(held))
    };
    let folds: Vec<Vec<usize>> = folds.into_iter().filter(|f| !f.is_empty()).collect();
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
