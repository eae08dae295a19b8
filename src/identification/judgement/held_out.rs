//! Errors on rows that were not fitted.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use crate::identification::error::IdentifyError;
use crate::identification::estimators::fit::Fit;
use crate::identification::estimators::identification::Identification;
use crate::identification::estimators::identifiers::Identifier;
use crate::identification::judgement::model_errors::{ErrorSummary, ModelErrors, errors_at, evaluate};
use crate::identification::problem::calibration_problem::CalibrationProblem;
use crate::identification::problem::start::sample_error;
use crate::identification::task::Task;
use crate::measurement::Dataset;
use crate::mechanism::{ForwardQuery, Mechanism};
use crate::pose::Pose;
use crate::solve::Triangle;

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
    /// Probability of errors at least this large by the noise and the uncertainty of the model; `None` where nothing tells.
    pub p_value: Option<f64>,
}

/// Predicts other data, in the frames of the problem, with what was found.
///
/// # Errors
/// [`IdentifyError::HeldOut`] if they cannot be used.
pub(crate) fn held_out_data(
    found: &Identification,
    mechanism: &dyn Mechanism,
    other: &Dataset,
) -> Result<HeldOut, IdentifyError> {
    let wrong = |cause| IdentifyError::HeldOut(Box::new(cause));
    let aligned = mechanism.with_values(&found.mechanism_values(), mechanism.home())?;
    let errors = evaluate(aligned.as_ref(), &found.own_values(), other).map_err(wrong)?;
    let p_value = surprise(found, aligned.as_ref(), other).map_err(wrong)?;
    Ok(HeldOut { rms: errors.rms(), samples: errors.samples.len(), p_value })
}

/// Whether noise and the covariance `F Fᵀ` of what was found explain the errors `r` on other data: `min |r + J F u|² + |u|²`
/// over `u` is χ² with as many degrees of freedom as there are rows.
fn surprise(found: &Identification, aligned: &dyn Mechanism, other: &Dataset) -> Result<Option<f64>, IdentifyError> {
    let own = found.own_values();
    if other.model().nuisance_parameters().len() != own.len() || found.parameters.iter().any(|p| p.sigma.is_none()) {
        return Ok(None);
    }
    let problem = CalibrationProblem::new(&Task::new(aligned, other))?;
    let values: Vec<f64> = found.parameters.iter().map(|p| p.value).collect();
    let (mut r, mut j) = problem.data_at(&DVector::from_vec(values))?;
    r /= found.noise_scale;
    j /= found.noise_scale;
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(found.covariance.clone());
    let factor = eigenvectors * DMatrix::from_diagonal(&eigenvalues.map(|v| v.max(0.0).sqrt()));
    let n = factor.ncols();
    let mut all = Triangle::of(&DMatrix::identity(n, n), &DVector::zeros(n));
    all.add(&(j * factor), &r, 0..r.len(), 1.0);
    let (cost, _) = all.misfit();
    let (rows, free) = (r.len() as f64, found.misfit.degrees_of_freedom as f64);
    Ok(match found.misfit.noise_known {
        true => ChiSquared::new(rows).ok().map(|chi| chi.sf(cost)),
        false => FisherSnedecor::new(rows, free).ok().map(|f| f.sf(cost / rows)),
    })
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
            rest.begin_at(rest.first_guess());
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
            Ok(Some(HeldOut { rms: all.rms(), samples: all.samples.len(), p_value: None }))
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
