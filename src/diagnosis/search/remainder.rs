//! Tests for unnamed causes of the residual that remains when every name has been tried.
//!
//! | test | sees |
//! |---|---|
//! | smooth: a polynomial of degree four in a covariate, at one place | anything that changes slowly with what was recorded |
//! | pose: one of degree two in a coordinate of the pose, at one place | an instrument that bends or scales, joints that are built otherwise |
//! | jump: a step at one value of a covariate, at one place | what latches, slips or switches at a temperature or an elevation |
//! | wave: a sine in commanded length, time or azimuth, up to the sampling limit or some 256 cycles | what repeats |
//! | scatter: the variance along one leg against the others | random errors of one leg, which depend on nothing recorded |
//! | size: χ² where the noise is known | everything else |
//!
//! A place is a leg, or a coordinate of the platform as it is seen: what moves the frame of an instrument is at no leg. A
//! covariate and a place are no cause; where covariates go together, another one explains nearly as much and is named
//! beside it.

use nalgebra::DVector;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::conditions::TIME;
use crate::diagnosis::answer::unknown::{Unknown, UnknownTest};
use crate::diagnosis::linear::hypotheses::EffectColumns;
use crate::diagnosis::linear::hypothesis::Hypothesis;
use crate::diagnosis::linear::model::Model;
use crate::diagnosis::linear::statistics::upper_f;
use crate::diagnosis::linear::unit_motion::Place;
use crate::diagnosis::search::covariates::Covariate;
use crate::diagnosis::search::curve::unknown;
use crate::diagnosis::search::unnamed::{Finding, Prepared, jumps, smooths, waves, worth};

/// Levels of the families of tests.
const SMOOTH: f64 = 1e-3;
const WAVE: f64 = 1e-3;
const JUMP: f64 = 5e-4;
const SCATTER: f64 = 5e-4;
const SIZE: f64 = 2e-3;

/// Worth of these names together beside the parameters alone, nats. A single name that acts along one direction only does
/// not pay for the others.
pub(crate) fn worth_of(without: &Model, groups: &[EffectColumns], names: &[Hypothesis]) -> f64 {
    let asked = without.ask_all(groups, names);
    let (gain, rank) = asked.gain();
    let together = worth(without, gain, rank as f64);
    let [name] = names else { return together };
    let alone = groups[name.group].alone.iter().map(|direction| worth(without, asked.along(direction).gain().0, 1.0));
    alone.fold(together, f64::max)
}

/// Residual along each leg, squared, and across it, over what the noise would give: `(Σ z²/(1 - h), number, the same
/// across)`.
fn scatter(model: &Model) -> Vec<(usize, f64)> {
    let table = model.table();
    let mut found = Vec::new();
    for leg in 0..table.joints.len() {
        let (mut along, mut dof_along, mut across, mut dof_across) = (0.0, 0.0, 0.0, 0.0);
        for (first, n) in model.kept.rows() {
            let v = table.a_t.view((table.joints.start + leg, first), (1, n)).transpose();
            let length = v.norm();
            if n < 2 || length == 0.0 {
                continue;
            }
            let d: DVector<f64> = v.column(0) / length;
            let r = model.residual.rows(first, n);
            let q_t = model.leverage(first, n);
            let z = d.dot(&r);
            let h = (q_t * &d).norm_squared();
            along += z * z;
            dof_along += 1.0 - h;
            across += r.norm_squared() - z * z;
            dof_across += n as f64 - 1.0 - (q_t.norm_squared() - h);
        }
        if dof_along > 5.0 && dof_across > 5.0 && across > 0.0 {
            let f = (along / dof_along) / (across / dof_across);
            found.push((leg, upper_f(f, dof_along, dof_across)));
        }
    }
    found
}

/// The most telling of what is left, or nothing.
pub(crate) fn remainder(model: &Model, covariates: &[Covariate]) -> Option<Unknown> {
    if model.is_rounding() {
        return None;
    }
    let prepared = Prepared::all(covariates);
    let mut findings = Vec::new();
    for (family, level) in &families(model, &prepared) {
        let tests = family.len().max(1) as f64;
        findings.extend(family.iter().filter_map(|f| Some((*f, f.significant(model, tests, *level)?.min(1.0)))));
    }
    findings.sort_by(|(a, _), (b, _)| b.worth.total_cmp(&a.worth));
    let scattered = scatter(model);
    let worst = scattered.iter().min_by(|a, b| a.1.total_cmp(&b.1)).copied();
    let scatter = worst.filter(|(_, p)| p * (scattered.len() as f64) < SCATTER);
    if let Some((best, p)) = findings.first() {
        let is_other = |f: &Finding<'_>| f.covariate.name != best.covariate.name && f.worth > best.worth - 3.0;
        let other = findings.iter().find(|(f, _)| is_other(f));
        return Some(Unknown { runner_up: other.map(|(f, _)| f.covariate.name.clone()), ..unknown(model, best, *p) });
    }
    if let Some((leg, p)) = scatter {
        return Some(Unknown { leg: Some(leg), ..Unknown::by(UnknownTest::Scatter, p * scattered.len() as f64) });
    }
    if model.noise.known {
        let p = ChiSquared::new(model.noise.dof).map_or(1.0, |d| d.sf(model.noise.rss));
        if p < SIZE {
            return Some(Unknown::by(UnknownTest::Size, p));
        }
    }
    None
}

/// The tests of every covariate at every place, each family with its level.
fn families<'a>(model: &Model, prepared: &[Prepared<'a>]) -> [(Vec<Finding<'a>>, f64); 3] {
    let mut families = [(Vec::new(), SMOOTH), (Vec::new(), WAVE), (Vec::new(), JUMP)];
    let [(smooth, _), (wave, _), (jump, _)] = &mut families;
    for place in model.table().places() {
        let here = (place, &model.samples_at(place));
        smooths(model, here, prepared, smooth);
        waves(model, here, prepared, wave);
        jumps(model, here, prepared, jump);
    }
    families
}

/// What describes best what is left, where it is known by other means that something is; with the probability of those.
pub(crate) fn most_telling(model: &Model, covariates: &[Covariate], p_value: f64) -> Option<Unknown> {
    let prepared = Prepared::all(covariates);
    let all = families(model, &prepared).into_iter().flat_map(|(family, _)| family);
    let best = all.max_by(|a, b| a.worth.total_cmp(&b.worth)).filter(|found| found.worth > 0.0)?;
    Some(unknown(model, &best, p_value))
}

/// The unknown that explains more than all names together, if there is one: its worth beside no names against theirs.
pub(crate) fn rival(without: &Model, covariates: &[Covariate], worth_of_names: f64, margin: f64) -> Option<Unknown> {
    let prepared = Prepared::all(covariates);
    let mut all = Vec::new();
    let mut steps = Vec::new();
    for leg in 0..without.table().joints.len() {
        let here = (Place::Joint(leg), &without.samples_at(Place::Joint(leg)));
        smooths(without, here, &prepared, &mut all);
        jumps(without, here, &prepared, &mut steps);
    }
    // Steps in time have names.
    all.extend(steps.into_iter().filter(|f| f.covariate.name != TIME && f.covariate.name != "row"));
    let tests = all.len() as f64;
    let best = all.into_iter().max_by(|a, b| a.worth.total_cmp(&b.worth))?;
    // What is not significant by itself withdraws nothing.
    let significant = best.significant(without, tests, SMOOTH).is_some();
    let p_value = || without.noise.p_value(best.gain, best.rank);
    (significant && best.worth > worth_of_names + margin).then(|| unknown(without, &best, p_value()))
}
