//! Which further measurements would tell rivals apart.
//!
//! A tie is a property of the measurement and not of its size: while temperature and time rise together no number of poses
//! tells growth from drift. What helps are other *conditions*. For each plan twelve samples are added to those that were
//! measured, and the part of the named effect that the rival cannot imitate in all of them,
//! `λ = |(I - P_b) X_a θ|²/σ²`, is computed from columns alone. About 10 is needed to tell two names apart.

use std::sync::Arc;

use crate::diagnosis::answer::result::{Cause, Diagnosis};
use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::hypotheses::Hypotheses;
use crate::diagnosis::linear::hypothesis::Hypothesis;
use crate::diagnosis::planning::design::{model_of, planned, table_of};
use crate::diagnosis::planning::scenarios::scenarios;
use crate::diagnosis::question::{Question, TOLERANCES};
use crate::diagnosis::search::stepwise::{TOLD_APART, related, separability};
use crate::effect::ScanPoint;
use crate::identification::{Conventions, Prior};
use crate::measurement::{Dataset, Noise, RowKind, Sample};
use crate::mechanism::Mechanism;

/// How well a plan tells one name from another.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Separation {
    /// The name that was given.
    pub effect: String,
    /// Its rival.
    pub rival: String,
    /// `λ` after the plan was measured.
    pub separability: f64,
}

/// Further measurements.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MeasurementPlan {
    /// The measurement, in words.
    pub what: String,
    /// The samples to add: joints and conditions. Empty for the present data.
    pub samples: Vec<Sample>,
    /// How well each pair of rivals would be told apart.
    pub separations: Vec<Separation>,
}

impl MeasurementPlan {
    /// The least of the separabilities.
    pub fn weakest(&self) -> f64 {
        self.separations.iter().map(|s| s.separability).fold(f64::INFINITY, f64::min)
    }

    /// True if every pair would be told apart.
    pub fn settles(&self) -> bool {
        self.weakest() >= TOLD_APART
    }
}

/// Plans that could settle the ties of a diagnosis, best first, and the present data as the last one. Empty without a tie.
///
/// # Errors
/// [`DiagnoseError`] if a plan leads to poses that do not exist.
pub fn settle(question: &Question<'_>, found: &Diagnosis) -> Result<Vec<MeasurementPlan>, DiagnoseError> {
    let tied: Vec<&Cause> = found.causes.iter().filter(|c| !c.tied_with.is_empty()).collect();
    if tied.is_empty() {
        return Ok(Vec::new());
    }
    let values = &found.values;
    let mechanism = question.mechanism.with_values(values, question.mechanism.home())?;
    let mut plans = Vec::new();
    for (what, added) in scenarios(question, mechanism.as_ref(), found) {
        match separations(question, mechanism.as_ref(), found, &tied, &added) {
            Ok(separations) => plans.push(MeasurementPlan { what, samples: added, separations }),
            // A plan that the mechanism cannot carry out is none.
            Err(DiagnoseError::Identify(_)) if !added.is_empty() => {}
            Err(error) => return Err(error),
        }
    }
    let present = plans.remove(0);
    plans.sort_by(|a, b| b.weakest().total_cmp(&a.weakest()));
    plans.push(present);
    Ok(plans)
}

fn separations(
    question: &Question<'_>,
    mechanism: &dyn Mechanism,
    found: &Diagnosis,
    tied: &[&Cause],
    added: &[Sample],
) -> Result<Vec<Separation>, DiagnoseError> {
    let mut samples: Vec<Sample> = question.data.iter().cloned().collect();
    samples.extend(added.iter().cloned());
    // The noise as it was found.
    let scale = if found.noise_scale.is_finite() { found.noise_scale } else { 1.0 };
    let stated = question.data.noise;
    let noise = Noise { position: stated.position * scale, rotation: stated.rotation * scale, ..stated };
    let data = planned(mechanism, samples, question.convention, noise, measured(question.data))?;
    let environment = Arc::new(question.environment.with_references_of(question.data));
    let prior = Prior::wide(mechanism, TOLERANCES, Conventions::FRAMES);
    let lags = lags_of(found);
    let (subject, _) = Hypotheses::new(mechanism, &data, environment, prior, &question.catalogue, &lags);
    let table = table_of(&subject)?;
    let named = |c: &Cause| candidate(&subject, &c.effect, &c.place(), c.row);
    let mut separations = Vec::new();
    for cause in tied {
        let others = found.causes.iter().filter(|c| !std::ptr::eq(*c, *cause)).filter_map(named).collect();
        let model = model_of(&subject, &table, others)?;
        // The name and its rivals: any of them may be the truth, so that every pair must be told apart.
        let own: Vec<f64> = cause.parameters.iter().map(|p| p.value).collect();
        let mut all = vec![(cause.effect.clone(), named(cause).map(|name| vec![name]), own)];
        for r in &cause.tied_with {
            let labels: Vec<&str> = r.parts().map(|part| part.effect.as_str()).collect();
            let places = r.parts().map(|part| candidate(&subject, &part.effect, &part.place(), part.row));
            let values = r.parts().flat_map(|part| part.values.iter().copied()).collect();
            all.push((labels.join(" + "), places.collect(), values));
        }
        for (k, (name, one, of_one)) in all.iter().enumerate() {
            for (rival, other, of_other) in &all[k + 1..] {
                // What a plan cannot see it cannot tell apart.
                let separability = one.as_ref().zip(other.as_ref()).map_or(0.0, |(one, other)| {
                    let apart = |a: &[Hypothesis], values: &[f64], b: &[Hypothesis]| {
                        separability(&model, &subject.groups, a, values, b, model.noise.variance())
                    };
                    // A special case cannot be imitated by less, and is imitated by the richer name: the larger of the two.
                    let (there, back) = (apart(one, of_one, other), apart(other, of_other, one));
                    let alike = |a: &Hypothesis, b: &Hypothesis| a == b || related(&subject.groups, a, b);
                    let nested = one.iter().any(|a| other.iter().any(|b| alike(a, b)));
                    if nested { there.max(back) } else { there.min(back) }
                });
                separations.push(Separation { effect: name.clone(), rival: rival.clone(), separability });
            }
        }
    }
    Ok(separations)
}

/// The coordinates that a planned sample measures: positions alone where the data have no angles.
fn measured(data: &Dataset) -> [bool; 6] {
    let angles = (0..data.len()).any(|k| data.rows(k).contains(&RowKind::Rotation));
    let poses = data.reading(0).0.rigid_pose(data.reading(0).1).is_some();
    [true, true, true, angles || poses, angles || poses, angles || poses]
}

/// The lags of the names and of their rivals.
fn lags_of(found: &Diagnosis) -> Vec<f64> {
    let own = found.causes.iter().filter_map(|c| c.lag);
    let of_rivals = found.causes.iter().flat_map(Cause::rivals).filter_map(|r| r.lag);
    let mut lags: Vec<f64> = own.chain(of_rivals).collect();
    lags.sort_by(f64::total_cmp);
    lags.dedup();
    lags
}

/// The place of an effect in the table of a subject.
fn candidate(subject: &Hypotheses<'_>, name: &str, at: &ScanPoint, row: Option<usize>) -> Option<Hypothesis> {
    let from = row.and_then(|row| subject.data.iter().position(|s| s.row.0 >= row));
    subject.find(name, at, from)
}
