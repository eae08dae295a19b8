//! Which further measurements would tell rivals apart.
//!
//! A tie is a property of the measurement and not of its size: while temperature and time rise together no number of poses
//! tells growth from drift. What helps are other *conditions*. For each plan twelve samples are added to those that were
//! measured, and the part of the named effect that the rival cannot imitate in all of them,
//! `λ = |(I - P_b) X_a θ|²/σ²`, is computed from columns alone. About 10 is needed to tell two names apart.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::design::{model_of, planned, table_of};
use super::model::Candidate;
use super::result::{Cause, Diagnosis};
use super::search::separability;
use super::subject::{Place, Subject};
use super::{DiagnoseError, Question, TOLERANCES};
use crate::conditions::Conditions;
use crate::effect::effect;
use crate::identification::Prior;
use crate::measurement::{Dataset, Noise, RowKind, Sample};
use crate::mechanism::Mechanism;

/// Samples that a plan adds.
const ADDED: usize = 12;
/// Separability at which two names are told apart.
pub const TOLD_APART: f64 = 10.0;

/// How well a plan tells one name from another.
#[derive(Clone, Debug, PartialEq)]
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
pub struct Plan {
    /// What to do, in a sentence.
    pub what: String,
    /// The samples to add: joints and conditions. Empty for the present data.
    pub samples: Vec<Sample>,
    /// How well each pair of rivals would be told apart.
    pub separations: Vec<Separation>,
}

impl Plan {
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
pub fn settle(question: &Question<'_>, found: &Diagnosis) -> Result<Vec<Plan>, DiagnoseError> {
    let tied: Vec<&Cause> = found.causes.iter().filter(|c| !c.tied_with.is_empty()).collect();
    if tied.is_empty() {
        return Ok(Vec::new());
    }
    let values = &found.values;
    let mechanism = question.mechanism.with_values(values, question.mechanism.home())?;
    let mut plans = Vec::new();
    for (what, added) in scenarios(question, mechanism.as_ref(), found) {
        match separations(question, mechanism.as_ref(), found, &tied, &added) {
            Ok(separations) => plans.push(Plan { what, samples: added, separations }),
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
    let surroundings = Arc::new(question.surroundings.with_references_of(question.data));
    let prior = Prior::wide(mechanism, TOLERANCES);
    let (subject, _) = Subject::new(mechanism, &data, surroundings, prior, &question.catalogue);
    let table = table_of(&subject)?;
    let named = |c: &Cause| candidate(&subject, &c.effect, c.leg, c.row, c.of.as_ref());
    let mut separations = Vec::new();
    for cause in tied {
        let others = found.causes.iter().filter(|c| !std::ptr::eq(*c, *cause)).filter_map(named).collect();
        let model = model_of(&subject, &table, others)?;
        // The name and its rivals: any of them may be the truth, so that every pair must be told apart.
        let own: Vec<f64> = cause.parameters.iter().map(|p| p.value).collect();
        let mut all = vec![(&cause.effect, named(cause), own)];
        for r in &cause.tied_with {
            all.push((&r.effect, candidate(&subject, &r.effect, r.leg, r.row, r.of.as_ref()), r.values.clone()));
        }
        for (k, (name, one, of_one)) in all.iter().enumerate() {
            for (rival, other, of_other) in &all[k + 1..] {
                // What a plan cannot see it cannot tell apart.
                let separability = one.as_ref().zip(other.as_ref()).map_or(0.0, |(one, other)| {
                    let apart = |a, values: &[f64], b| {
                        separability(&model, &subject.groups, a, values, b, model.noise.variance())
                    };
                    // A special case cannot be imitated by less, and is imitated by the richer name: the larger of the two.
                    let (there, back) = (apart(one, of_one, other), apart(other, of_other, one));
                    if related(&subject, one, other) { there.max(back) } else { there.min(back) }
                });
                separations.push(Separation { effect: (*name).clone(), rival: (*rival).clone(), separability });
            }
        }
    }
    Ok(separations)
}

/// True if one of two effects is a special case of the other.
fn related(subject: &Subject<'_>, one: &Candidate, other: &Candidate) -> bool {
    let effect = |c: &Candidate| &subject.groups[c.group].effect;
    let (a, b) = (effect(one), effect(other));
    a.special_case_of().contains(&b.name()) || b.special_case_of().contains(&a.name())
}

/// The coordinates that a planned sample measures: positions alone where the data have no angles.
fn measured(data: &Dataset) -> [bool; 6] {
    let angles = (0..data.len()).any(|k| data.rows(k).contains(&RowKind::Rotation));
    let poses = data.reading(0).0.rigid_pose(data.reading(0).1).is_some();
    [true, true, true, angles || poses, angles || poses, angles || poses]
}

/// The place of an effect in the table of a subject.
fn candidate(
    subject: &Subject<'_>,
    name: &str,
    leg: Option<usize>,
    row: Option<usize>,
    of: Option<&String>,
) -> Option<Candidate> {
    let group = subject.groups.iter().position(|g| g.effect.name() == name)?;
    let is_it = |p: &Place| p.at.leg == leg && p.at.covariate.as_ref() == of;
    let place = subject.groups[group].places.iter().position(is_it)?;
    let from = row.and_then(|row| subject.data.iter().position(|s| s.row >= row));
    Some(Candidate { group, place, from })
}

/// The present data, then plans for what the names and their rivals depend on.
fn scenarios(question: &Question<'_>, mechanism: &dyn Mechanism, found: &Diagnosis) -> Vec<(String, Vec<Sample>)> {
    let data = question.data;
    let n = data.len();
    let chosen: Vec<&Sample> = (0..ADDED).map(|k| data.sample(k * (n - 1) / (ADDED - 1))).collect();
    let last = &data.sample(n - 1).conditions;
    let first = &data.sample(0).conditions;
    let depends = depends_on(found);
    let leg = found.causes.iter().find_map(|c| c.leg.or_else(|| c.tied_with.iter().find_map(|r| r.leg))).unwrap_or(0);
    let temperatures: Vec<String> = last.covariates.keys().filter(|k| k.starts_with("temp_")).cloned().collect();
    let legs: Vec<&String> = temperatures.iter().filter(|t| t.starts_with("temp_leg")).collect();
    // After the run, with its last conditions, one more change each.
    let plan = |change: &dyn Fn(usize, &mut Conditions)| -> Vec<Sample> {
        let mut previous = data.sample(n - 1).joints.clone();
        let make = |(k, s): (usize, &&Sample)| {
            let mut conditions = last.clone();
            conditions.previous_joints = Some(std::mem::replace(&mut previous, s.joints.clone()));
            if let Some(run) = &mut conditions.run {
                run.row = n + k;
                run.part = 1.05 + 0.01 * k as f64;
            }
            change(k, &mut conditions);
            Sample { id: None, row: n + k, joints: s.joints.clone(), conditions }
        };
        chosen.iter().enumerate().map(make).collect()
    };
    let mut all: Vec<(String, Vec<Sample>)> = vec![("nothing more: the present data".into(), Vec::new())];
    let same = plan(&|k, c| {
        let time = c.get("time");
        c.covariates.clone_from(&chosen[k].conditions.covariates);
        c.gravity = chosen[k].conditions.gravity;
        if let Some(time) = time {
            c.covariates.insert("time".into(), time);
        }
    });
    all.push((format!("{ADDED} poses again under the conditions of the run"), same));
    let mut wide = plan(&|_, _| {});
    for sample in &mut wide {
        let at = Conditions::unknown();
        let pose = mechanism.forward(mechanism.values(), &sample.joints, &at, &mechanism.home());
        let twice = pose.ok().and_then(|pose| {
            let (q, home) =
                (question.convention.coordinates(&pose), question.convention.coordinates(&mechanism.home()));
            let far: [f64; 6] = std::array::from_fn(|k| 2.0 * q[k] - home[k]);
            mechanism.inverse(mechanism.values(), &question.convention.pose(&far), &at).ok()
        });
        if let Some(joints) = twice.filter(|joints| mechanism.within_strokes(joints)) {
            sample.joints = joints;
        }
    }
    all.push((format!("{ADDED} poses twice as far from home"), wide));
    if !temperatures.is_empty() && (depends.contains("temperature") || depends.contains("time")) {
        let cooled = plan(&|_, c| {
            for name in &temperatures {
                if let Some(t) = first.get(name) {
                    c.covariates.insert(name.clone(), t);
                }
            }
        });
        all.push((format!("{ADDED} poses after the machine went back to its temperatures of the first row"), cooled));
        let heated = |names: &[&String], by: f64| {
            plan(&|_, c| {
                for name in names {
                    if let Some(t) = c.covariates.get_mut(*name) {
                        *t += by;
                    }
                }
            })
        };
        if !legs.is_empty() {
            all.push((format!("{ADDED} poses with the legs alone heated by 2 K"), heated(&legs, 2.0)));
        }
        let own = format!("temp_leg{}", leg + 1);
        if temperatures.contains(&own) {
            all.push((format!("{ADDED} poses with leg {} alone heated by 5 K", leg + 1), heated(&[&own], 5.0)));
        }
        // One thing after the other settles what no single one does.
        let bodies: Vec<Vec<&String>> = ["temp_platform", "temp_base"]
            .iter()
            .filter_map(|name| temperatures.iter().find(|t| *t == name).map(|t| vec![t]))
            .chain((!legs.is_empty()).then(|| legs.clone()))
            .chain(temperatures.iter().find(|t| **t == own).map(|t| vec![t]))
            .collect();
        if bodies.len() > 1 {
            let in_turn = plan(&|k, c| {
                for name in &bodies[k % bodies.len()] {
                    if let Some(t) = c.covariates.get_mut(*name) {
                        *t += 5.0;
                    }
                }
            });
            let what = "each body alone (platform, base, all legs, one leg) heated by 5 K";
            all.push((format!("{ADDED} poses with {what}, in turn"), in_turn));
        }
        for (name, part) in [("temp_platform", "platform"), ("temp_base", "base")] {
            let name = name.to_owned();
            if temperatures.contains(&name) {
                all.push((format!("{ADDED} poses with the {part} alone heated by 2 K"), heated(&[&name], 2.0)));
            }
        }
    }
    if depends.contains("gravity") && last.gravity.is_some() {
        let tipped = plan(&|k, c| {
            let from = &chosen[k].conditions;
            let degrees = if k % 2 == 0 { 20.0_f64 } else { 90.0 };
            let elevation = degrees.to_radians();
            // Gravity stays in the plane in which it was.
            let across = from.gravity.map(|g| nalgebra::Vector3::new(g.x, g.y, 0.0)).filter(|g| g.norm() > 1e-6);
            let axis = across.map_or_else(nalgebra::Vector3::x, |g| g.normalize());
            c.gravity = Some(axis * elevation.cos() - nalgebra::Vector3::z() * elevation.sin());
            c.covariates.insert("elevation".into(), elevation);
        });
        all.push((format!("{ADDED} poses in turn at elevation 20 deg and 90 deg"), tipped));
        if last.get("payload").is_some() {
            let loaded = plan(&|k, c| {
                c.covariates.insert("payload".into(), if k % 2 == 0 { 0.0 } else { 100.0 });
            });
            all.push((format!("{ADDED} poses in turn without payload and with 100 kg"), loaded));
        }
    }
    all
}

/// Kinds of conditions that the names and their rivals depend on.
fn depends_on(found: &Diagnosis) -> BTreeSet<&'static str> {
    let names = found
        .causes
        .iter()
        .flat_map(|c| c.tied_with.iter().map(|r| r.effect.as_str()).chain(std::iter::once(c.effect.as_str())));
    let mut kinds = BTreeSet::new();
    for name in names {
        let Some(effect) = effect(name) else { continue };
        for covariate in effect.covariates(&crate::effect::ScanPoint::leg(0)) {
            kinds.insert(match covariate.as_str() {
                c if c.starts_with("temp_") => "temperature",
                "elevation" | "payload" => "gravity",
                "time" => "time",
                _ => "other",
            });
        }
    }
    kinds
}
