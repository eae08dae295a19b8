//! From the end of the search to the answer.

use crate::diagnosis::answer::evidence::{added_variable, joint_residuals};
use crate::diagnosis::answer::gain::{folds, held_out, rms};
use crate::diagnosis::answer::limits::{lambda, limit};
use crate::diagnosis::answer::result::{
    Cause, CauseParameter, Diagnosis, Gain, NoiseVaries, NotFound, NotTestable, Rival, Unknown, Verdict,
};
use crate::diagnosis::linear::hypotheses::Hypotheses;
use crate::diagnosis::linear::model::{Hypothesis, Model};
use crate::diagnosis::planning::settle::TOLD_APART;
use crate::diagnosis::search::covariates::covariates;
use crate::diagnosis::search::iteration::SearchState;
use crate::diagnosis::search::remainder::{remainder, rival, worth_of};
use crate::diagnosis::search::stepwise::{Score, TIED, related, scores, separability};
use crate::diagnosis::{DiagnoseError, Question};
use crate::effect::EffectParameter;
use crate::identification::Registration;
use crate::units::{Dimension, three_digits};

/// A size below this many limits is tentative.
const TENTATIVE: f64 = 2.0;
/// Residuals this many times the stated noise belong to another mechanism, or to none.
const HOPELESS: f64 = 100.0;
/// A value that is known to this many usual sizes only is not known.
const UNSEEN: f64 = 1e6;
/// Residuals that names made this much smaller are those of rounded numbers.
const ROUNDING: f64 = 1e-6;
/// Usual sizes beyond which a value is not plausible.
const PLAUSIBLE: f64 = 10.0;

/// Puts the answer together.
pub(crate) fn findings(
    question: &Question<'_>,
    subject: &Hypotheses<'_>,
    state: &SearchState,
    mut not_testable: Vec<NotTestable>,
    registration: &Registration,
    noise_varies: Option<NoiseVaries>,
) -> Result<Diagnosis, DiagnoseError> {
    let model = state.model(subject, state.names.clone())?;
    let without = state.model(subject, Vec::new())?;
    let known = covariates(subject.data);
    let mut causes = causes(subject, state, &model)?;
    let mut unknown = remainder(&model, &known).filter(|u| !is_rounding(state, &without, &model, u.leg));
    let mut effects = state.point.effects.clone();
    let mut withdrawn = false;
    if !state.names.is_empty() {
        let worth = worth_of(&without, &subject.groups, &state.names) - price_of_places(subject, &state.names);
        if let Some(found) = rival(&without, &known, worth, TIED) {
            let names = causes.iter().map(|c| c.effect.clone()).collect();
            unknown = Some(Unknown { withdrawn: names, ..found });
            causes.clear();
            effects.clear();
            withdrawn = true;
        }
    }
    if unknown.is_none() && patchwork(subject, &state.names) {
        // Jumps and drifts stacked on each other describe anything that changes with time.
        unknown = Some(Unknown {
            covariate: Some(if known.iter().any(|c| c.name == "time") { "time".into() } else { "row".into() }),
            ..Unknown::by("patchwork", causes.iter().map(|c| c.p_value).fold(0.0, f64::max))
        });
    }
    if subject.data.noise.known && is_hopeless(subject, state, if withdrawn { &without } else { &model }) {
        let names = causes.drain(..).map(|c| c.effect).collect();
        effects.clear();
        withdrawn = true;
        unknown = Some(Unknown { withdrawn: names, ..Unknown::by("misfit", 0.0) });
    }
    let (judged, names) = if withdrawn { (&without, Vec::new()) } else { (&model, state.names.clone()) };
    let kept = state.kept();
    let verdict = match (&unknown, causes.is_empty()) {
        (Some(_), _) => Verdict::Unknown,
        (None, true) => Verdict::Clean,
        (None, false) if causes.iter().any(|c| !c.tied_with.is_empty()) => Verdict::Tied,
        (None, false) => Verdict::Named,
    };
    let (not_found, unseen) = not_found(subject, judged, &without, &names, &causes);
    not_testable.extend(unseen);
    for effect in &mut effects {
        effect.range = effect.range_over(&subject.data.subset(&kept));
    }
    let rows: Vec<usize> = state.left_out.iter().map(|k| subject.data.sample(*k).row).collect();
    let step = judged.step();
    let specs = subject.mechanism.parameters().len();
    let values = state.point.values.iter().zip(step.iter()).map(|(v, d)| v + d).collect();
    let own = state.full.own.iter().zip(step.iter().skip(specs)).map(|(v, d)| v + d).collect();
    let mut warnings = Vec::new();
    if registration.applied {
        warnings.push(
            "the data are in a different frame from the mechanism file; causes act in the base frame of the file, and \
             an extended model is written in that frame"
                .into(),
        );
    }
    // What no name explains changes the ratio too.
    if let (Some([position, rotation]), None) = (subject.kind_spreads, &unknown) {
        warnings.push(format!(
            "the ratio of position noise to rotation noise is {} times the stated one; rows are weighted by the \
             estimated noise",
            three_digits(position / rotation)
        ));
    }
    if subject.mechanism.parameters().iter().all(|p| p.tolerance.is_none()) {
        warnings.push("the mechanism file states no [tolerance]; parameters are only kept finite".into());
    }
    Ok(Diagnosis {
        verdict,
        causes,
        unknown,
        misread: None,
        outlier_rows: rows,
        residuals: joint_residuals(subject, state, &without, judged),
        noise_varies,
        correlation: state.correlation,
        gain: gain(question, &without, judged, &kept),
        not_found,
        not_testable,
        before: rms(&state.table, &without.residual, &kept),
        after: rms(&state.table, &judged.residual, &kept),
        noise_scale: judged.noise.variance().sqrt() * subject.kind_spreads.map_or(1.0, |[p, r]| (p * r).sqrt()),
        samples: subject.data.len(),
        joints: subject.mechanism.joints().iter().map(|j| j.name.clone()).collect(),
        values,
        own,
        effects,
        environment: (*subject.environment).clone(),
        frames: registration.frames,
        warnings,
    })
}

/// True if what is left at a joint is less than the digits that any file has.
fn is_rounding(state: &SearchState, without: &Model<'_>, model: &Model<'_>, joint: Option<usize>) -> bool {
    let of = |m: &Model<'_>| state.table.spreads_of(&m.residual, &state.left_out);
    joint.is_some_and(|k| of(model)[k] < ROUNDING * of(without)[k])
}

/// True if what is left is far above the stated noise.
fn is_hopeless(subject: &Hypotheses<'_>, state: &SearchState, model: &Model<'_>) -> bool {
    let left = rms(&state.table, &model.residual, &state.kept());
    let noise = &subject.data.noise;
    let above = |rms: Option<f64>, sigma: f64| rms.is_some_and(|v| v > HOPELESS * 3.0_f64.sqrt() * sigma);
    above(left.position, noise.position) || above(left.rotation, noise.rotation)
}

/// True if one effect that acts from a row on is named twice, or three names are about time.
fn patchwork(subject: &Hypotheses<'_>, names: &[Hypothesis]) -> bool {
    let group = |name: &Hypothesis| &subject.groups[name.group];
    let twice = |(k, name): (usize, &Hypothesis)| {
        name.from.is_some() && names[..k].iter().any(|other| other.group == name.group)
    };
    let about_time =
        |name: &&Hypothesis| group(name).effect.covariates(&group(name).places[name.place].at).contains(&"time".into());
    names.iter().enumerate().any(twice) || names.iter().filter(about_time).count() >= 3
}

/// What it costs, in nats, to choose the places of names.
fn price_of_places(subject: &Hypotheses<'_>, names: &[Hypothesis]) -> f64 {
    let places = |name: &Hypothesis| {
        let group = &subject.groups[name.group];
        group.places.len() * name.from.map_or(1, |_| subject.data.len())
    };
    names.iter().map(|name| (places(name) as f64).ln()).sum()
}

fn causes(subject: &Hypotheses<'_>, state: &SearchState, model: &Model<'_>) -> Result<Vec<Cause>, DiagnoseError> {
    let step = model.step();
    let covariance = model.effect_covariance() * (model.noise.variance() * state.fitting.inflation);
    let rows: Vec<usize> = subject.data.iter().map(|s| s.row).collect();
    let mut all = Vec::with_capacity(state.names.len());
    let mut at = 0;
    for (k, name) in state.names.iter().enumerate() {
        let group = &subject.groups[name.group];
        let p = group.parameters.len();
        let values: Vec<f64> = step.rows(model.table.nuisance + at, p).iter().copied().collect();
        let mut others = state.names.clone();
        others.remove(k);
        let without = state.model(subject, others.clone())?;
        let scores = scores(&without, &subject.groups);
        let tests = scores.iter().filter(|s| s.rank > 0).count();
        let own = &scores[name.group];
        let place = name.at(&subject.groups, &rows);
        let variance = model.noise.variance() * state.fitting.inflation;
        let sigma = model.noise.variance().sqrt();
        let tied_with = rivals(subject, &without, &scores, name, &values, &others, variance);
        let lambda_limit = lambda(own.rank, tests, own.places);
        let size = (own.gain / without.noise.variance_after(own.gain, own.rank as f64) / lambda_limit).sqrt();
        let parameter = |(i, spec): (usize, &EffectParameter)| CauseParameter {
            name: spec.name.clone(),
            value: values[i],
            sigma: Some(covariance[(at + i, at + i)].max(0.0).sqrt()).filter(|s| *s < UNSEEN * spec.scale),
            dimension: dimension(subject, spec.dimension, place.leg),
            scale: spec.scale,
        };
        all.push(Cause {
            effect: group.effect.name().into(),
            cause: group.effect.cause().into(),
            remedy: group.effect.remedy().into(),
            acts_on: group.effect.acts_on(),
            leg: place.leg,
            row: place.row,
            of: place.covariate,
            parameters: group.parameters.iter().enumerate().map(parameter).collect(),
            p_value: own.p_value,
            evidence: own.evidence,
            tied_with,
            size_over_limit: size,
            tentative: size < TENTATIVE,
            added_variable: added_variable(state, &subject.groups, &without, name, &values, sigma),
            plausible: group.parameters.iter().zip(&values).all(|(p, v)| v.abs() <= PLAUSIBLE * p.scale),
        });
        at += p;
    }
    all.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    Ok(all)
}

/// What a parameter measures at a leg: where joints differ, that of the joint of the leg and not of the first one.
fn dimension(subject: &Hypotheses<'_>, stated: Dimension, leg: Option<usize>) -> Dimension {
    let joints = subject.mechanism.joints();
    match leg.and_then(|leg| joints.get(leg)) {
        Some(joint) if stated == joints[0].dimension => joint.dimension,
        _ => stated,
    }
}

/// Names within a factor of 20 in evidence, and within a factor of 400 those that the data can hardly tell from the named
/// one, unless one is a special case of the other.
fn rivals(
    subject: &Hypotheses<'_>,
    without: &Model<'_>,
    scores: &[Score],
    name: &Hypothesis,
    values: &[f64],
    others: &[Hypothesis],
    variance: f64,
) -> Vec<Rival> {
    let own = scores[name.group].evidence;
    let rows: Vec<usize> = subject.data.iter().map(|s| s.row).collect();
    let mut tied: Vec<Rival> = Vec::new();
    for s in scores.iter().filter(|s| s.rank > 0 && s.candidate.group != name.group && !others.contains(&s.candidate)) {
        let log_bayes_factor = own - s.evidence;
        // What the data can hardly tell apart is not told apart by the sizes that are usual.
        let reach = if related(&subject.groups, name, &s.candidate) { TIED } else { 2.0 * TIED };
        if log_bayes_factor > reach {
            continue;
        }
        let separability = separability(without, &subject.groups, name, values, &s.candidate, variance);
        if log_bayes_factor <= TIED || separability < TOLD_APART {
            let at = s.candidate.at(&subject.groups, &rows);
            tied.push(Rival {
                effect: subject.groups[s.candidate.group].effect.name().into(),
                leg: at.leg,
                row: at.row,
                of: at.covariate,
                values: without.ask_all(&subject.groups, std::slice::from_ref(&s.candidate)).values(),
                log_bayes_factor,
                separability,
            });
        }
    }
    tied.sort_by(|a, b| a.log_bayes_factor.total_cmp(&b.log_bayes_factor));
    tied
}

/// Effects that were not found with their limits, and those that these data cannot see.
fn not_found(
    subject: &Hypotheses<'_>,
    model: &Model<'_>,
    without: &Model<'_>,
    names: &[Hypothesis],
    causes: &[Cause],
) -> (Vec<NotFound>, Vec<NotTestable>) {
    let (mut found, mut unseen) = (Vec::new(), Vec::new());
    let tests = subject.groups.len();
    for (k, group) in subject.groups.iter().enumerate() {
        let name = group.effect.name();
        let tied = causes.iter().any(|c| c.tied_with.iter().any(|r| r.effect == name));
        if tied || names.iter().any(|n| n.group == k) {
            continue;
        }
        match limit(model, &subject.groups, k, tests) {
            Some(limit) => found.push(limit),
            // What a named effect contains was looked for with it.
            None if limit(without, &subject.groups, k, tests).is_some() => {}
            None => unseen.push(NotTestable::unchanging(group)),
        }
    }
    (found, unseen)
}

fn gain(question: &Question<'_>, without: &Model<'_>, with: &Model<'_>, kept: &[usize]) -> Gain {
    let random = folds(kept, Some(question.seed));
    let blocks = folds(kept, None);
    let (before, after) = (held_out(without, &random), held_out(with, &random));
    let (blocked_before, blocked_after) = (held_out(without, &blocks), held_out(with, &blocks));
    let noise = &question.data.noise;
    let floor = |sigma: f64| noise.known.then(|| 3.0_f64.sqrt() * sigma);
    Gain {
        position_before: before.and_then(|e| e.position),
        position_after: after.and_then(|e| e.position),
        rotation_before: before.and_then(|e| e.rotation),
        rotation_after: after.and_then(|e| e.rotation),
        blocked_position_before: blocked_before.and_then(|e| e.position),
        blocked_position_after: blocked_after.and_then(|e| e.position),
        noise_floor_position: floor(noise.position),
        noise_floor_rotation: floor(noise.rotation),
    }
}
