//! From a question to an answer: preflight, search, findings.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::DVector;

use crate::conditions::TIME;
use crate::diagnosis::answer::findings::findings;
use crate::diagnosis::answer::result::{Diagnosis, Gain, Misread, Verdict};
use crate::diagnosis::answer::unknown::{Unknown, UnknownTest};
use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::hypotheses::Hypotheses;
use crate::diagnosis::preflight::beside_effects::misread_beside_effects;
use crate::diagnosis::preflight::compare::preflight;
use crate::diagnosis::question::{Question, TOLERANCES};
use crate::diagnosis::search::agreement::stuck;
use crate::diagnosis::search::iteration::Search;
use crate::diagnosis::search::lags::with_lags;
use crate::diagnosis::search::structure::still_gross;
use crate::effect::Environment;
use crate::identification::{
    CalibrationProblem, Conventions, ErrorSummary, Identifier, LevenbergMarquardt, Prior, PriorPolicy, Task, register,
};
use crate::measurement::{Dataset, Rows};
use crate::mechanism::Mechanism;
use crate::pose::Pose;
use crate::units::shortened;

/// Samples that can be searched in minutes, with a few gigabytes.
const MOST_SAMPLES: usize = 10_000;

/// Says what the model gets wrong.
///
/// # Errors
/// [`DiagnoseError`] if there is no answer at all.
pub fn diagnose(question: &Question<'_>) -> Result<Diagnosis, DiagnoseError> {
    let Question { mechanism, data, convention, .. } = *question;
    if data.len() > MOST_SAMPLES {
        return Err(DiagnoseError::TooManySamples { samples: data.len(), most: MOST_SAMPLES });
    }
    if let Some(reason) = standing_still(mechanism, data) {
        return Ok(undecided(data, reason));
    }
    if let Some(misread) = preflight(mechanism, data, &convention) {
        return Ok(misread_file(data, misread));
    }
    let found = explained(question)?;
    let otherwise = |question: &Question<'_>| explained(question).ok();
    match misread_beside_effects(question, &found, otherwise) {
        Some(misread) => Ok(misread_file(data, misread)),
        None => Ok(found),
    }
}

/// The causes of what is left when the file is read as it stands.
fn explained(question: &Question<'_>) -> Result<Diagnosis, DiagnoseError> {
    let Question { mechanism, data, .. } = *question;
    let prior = Prior::wide(mechanism, TOLERANCES, Conventions::FRAMES);
    let (data, gaps) = complete_rows(data);
    let registration = register(mechanism, &data);
    let data = data.with_frames(registration.frames);
    let prior = match zeros_are_elsewhere(mechanism, &data) {
        true => Prior::wide(mechanism, TOLERANCES, Conventions { zeros: true, ..Conventions::FRAMES }),
        false => prior,
    };
    let environment = Arc::new(question.environment.with_references_of(&data));
    let (subject, missing) = Hypotheses::new(mechanism, &data, environment, prior, &question.catalogue, &[]);
    let known = question.noise_known && data.noise.known;
    let mut search = Search { subject: &subject, known, left_out: None };
    let mut state = match search.reweighted() {
        Err(error @ DiagnoseError::TooFewRows { .. }) => return Ok(undecided(&data, error.to_string())),
        state => state?,
    };
    let mut found = findings(question, &subject, &state, missing.clone(), &registration)?;
    let unknown = found.unknown.as_ref();
    if let Some(left_out) = unknown.and_then(|u| still_gross(&subject, &state, u).transpose()).transpose()? {
        search.left_out = Some(left_out);
        state = search.reweighted()?;
        found = findings(question, &subject, &state, missing.clone(), &registration)?;
    }
    let unknown = found.unknown.as_ref().is_some_and(may_be_late);
    if let Some((subject, state)) = with_lags(&search, &state, unknown, &question.catalogue)? {
        found = findings(question, &subject, &state, missing, &registration)?;
    }
    found.warnings.extend(gaps);
    Ok(found)
}

/// True for what may be a temperature that acts with a lag: it depends on temperature or time.
fn may_be_late(unknown: &Unknown) -> bool {
    let slow = |name: &String| name == TIME || name == "row" || name.starts_with("temp_");
    unknown.test != UnknownTest::Misfit && unknown.covariate.as_ref().is_some_and(slow)
}

/// True if the joints count from elsewhere than the drawing says, by more than a search would allow them: a convention and no
/// cause.
fn zeros_are_elsewhere(mechanism: &dyn Mechanism, data: &Dataset) -> bool {
    let task = Task { prior: PriorPolicy::Tolerance, conventions: Conventions::FRAMES, ..Task::new(mechanism, data) };
    let found =
        CalibrationProblem::new(&task).and_then(|mut problem| LevenbergMarquardt::default().estimate(&mut problem));
    found.is_ok_and(|fit| {
        let values = &fit.values.as_slice()[..mechanism.parameters().len()];
        Conventions::contradicted(mechanism, mechanism.values(), values, TOLERANCES).zeros
    })
}

/// Part of the rows that must have a covariate for rows without it to be left out, rather than the covariate.
const MOST: f64 = 0.8;
/// Part of the rows that must be left where several covariates have gaps.
const ENOUGH: f64 = 0.5;

/// The samples that have the covariates with few gaps, and what to say of the others. A covariate with gaps would else be
/// none, and its effects would go to their relatives. Where the gaps of several would leave too few rows, those whose gaps
/// cost most are given up, one after the other.
fn complete_rows(data: &Dataset) -> (Dataset, Vec<String>) {
    let n = data.len();
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for name in data.iter().flat_map(|s| s.conditions.covariates.keys()) {
        *counts.entry(name).or_default() += 1;
    }
    let nearly = |count: &usize| *count < n && *count as f64 >= MOST * n as f64;
    let mut asked: Vec<&str> = counts.iter().filter(|(_, c)| nearly(c)).map(|(name, _)| *name).collect();
    if asked.is_empty() {
        return (data.clone(), Vec::new());
    }
    let complete = |asked: &[&str]| -> Vec<usize> {
        let whole = |k: &usize| asked.iter().all(|name| data.sample(*k).conditions.get(name).is_some());
        (0..n).filter(whole).collect()
    };
    let mut given_up = Vec::new();
    let mut kept = complete(&asked);
    while (kept.len() as f64) < ENOUGH * n as f64 {
        let without = |k: usize| {
            let mut others = asked.clone();
            others.remove(k);
            complete(&others).len()
        };
        let Some(costly) = (0..asked.len()).max_by_key(|k| without(*k)) else { break };
        given_up.push(asked.remove(costly));
        kept = complete(&asked);
    }
    let mut warnings = Vec::new();
    if !given_up.is_empty() {
        let names = given_up.join(", ");
        warnings.push(format!("{names}: too many empty cells; effects that depend on them are not tested"));
    }
    if kept.len() == n {
        return (data.clone(), warnings);
    }
    let is_kept = |k: &usize| kept.binary_search(k).is_ok();
    let rows: Vec<String> = (0..n).filter(|k| !is_kept(k)).map(|k| data.sample(k).row.to_string()).collect();
    let names = asked.join(", ");
    warnings.push(format!("data rows {} are left out: {names} have empty cells there", shortened(&rows)));
    (data.subset(&kept), warnings)
}

/// What there is to say of an instrument whose readings do not follow the commands, if it is so.
fn standing_still(mechanism: &dyn Mechanism, data: &Dataset) -> Option<String> {
    let own: Vec<f64> = data.model().nuisance_parameters().iter().map(|_| 0.0).collect();
    let residuals = |pose: &dyn Fn(usize) -> Option<Pose>| -> Option<Vec<DVector<f64>>> {
        (0..data.len())
            .map(|k| {
                let mut out = Rows::sized(data.rows(k).len(), own.len());
                data.evaluate(k, &pose(k)?, &own, &mut out);
                // In units of the noise.
                let sigma = data.covariance(k).diagonal().map(f64::sqrt);
                Some(out.residual.component_div(&sigma))
            })
            .collect()
    };
    let home = mechanism.home();
    let commanded = |k: usize| {
        let sample = data.sample(k);
        mechanism.forward(mechanism.values(), &sample.joints, &sample.conditions, &home).ok()
    };
    stuck(data, &residuals(&|_| Some(home))?, &residuals(&commanded)?)
}

fn misread_file(data: &Dataset, misread: Misread) -> Diagnosis {
    Diagnosis { verdict: Verdict::Misread, misread: Some(misread), ..without_answer(data) }
}

fn undecided(data: &Dataset, reason: String) -> Diagnosis {
    Diagnosis { verdict: Verdict::Undecided, undecided: Some(reason), ..without_answer(data) }
}

/// Nothing was fitted.
fn without_answer(data: &Dataset) -> Diagnosis {
    Diagnosis {
        verdict: Verdict::Undecided,
        undecided: None,
        causes: Vec::new(),
        unknown: None,
        misread: None,
        outlier_rows: Vec::new(),
        residuals: Vec::new(),
        noise_varies: None,
        correlation: None,
        gain: Gain::default(),
        not_found: Vec::new(),
        not_testable: Vec::new(),
        before: ErrorSummary::default(),
        after: ErrorSummary::default(),
        noise_scale: f64::NAN,
        samples: data.len(),
        joints: Vec::new(),
        values: Vec::new(),
        own: Vec::new(),
        effects: Vec::new(),
        environment: Environment::default(),
        frames: data.frames,
        warnings: Vec::new(),
    }
}
