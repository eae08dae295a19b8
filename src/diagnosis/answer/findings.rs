//! From the end of the search to the answer.

use crate::conditions::TIME;
use crate::diagnosis::answer::causes::causes;
use crate::diagnosis::answer::evidence::joint_residuals;
use crate::diagnosis::answer::gain::{folds, held_out, rms};
use crate::diagnosis::answer::limits::limit;
use crate::diagnosis::answer::not_excluded::Unseen;
use crate::diagnosis::answer::result::{Cause, Diagnosis, Gain, NotFound, NotTestable, Verdict};
use crate::diagnosis::answer::unknown::{Unknown, UnknownTest};
use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::hypotheses::Hypotheses;
use crate::diagnosis::linear::hypothesis::Hypothesis;
use crate::diagnosis::linear::model::Model;
use crate::diagnosis::question::Question;
use crate::diagnosis::search::agreement::{LackOfFit, noise_exceeded};
use crate::diagnosis::search::covariates::{Covariate, covariates, with_coordinates};
use crate::diagnosis::search::iteration::SearchState;
use crate::diagnosis::search::remainder::{most_telling, remainder, rival, worth_of};
use crate::diagnosis::search::stepwise::{LEVEL, TIED};
use crate::effect::ActsOn;
use crate::identification::{ErrorSummary, Registration};
use crate::units::{Dimension, three_digits};

/// Residuals this many times the stated noise belong to another mechanism, or to none.
const HOPELESS: f64 = 100.0;
/// Residuals that names made this much smaller are those of rounded numbers.
const ROUNDING: f64 = 1e-6;

/// Puts the answer together.
pub(crate) fn findings(
    question: &Question<'_>,
    subject: &Hypotheses<'_>,
    state: &SearchState,
    mut not_testable: Vec<NotTestable>,
    registration: &Registration,
) -> Result<Diagnosis, DiagnoseError> {
    let model = &state.model;
    let alone = match state.names() {
        [] => None,
        _ => Some(state.with_names(subject, Vec::new())?),
    };
    let without = alone.as_ref().unwrap_or(model);
    let kept = state.kept().samples();
    let gains = gain(question, without, model, &kept);
    let beyond = Unseen::new(subject, state, &question.catalogue, &not_testable)?;
    let Conclusion { causes, unknown, withdrawn } = conclude(subject, state, without, (&gains, &beyond))?;
    let (judged, names) = if withdrawn { (without, Vec::new()) } else { (model, state.names().to_vec()) };
    let mut effects = if withdrawn { Vec::new() } else { state.point.effects.clone() };
    let (not_found, unseen) = not_found(subject, judged, without, &names, &causes);
    not_testable.extend(unseen);
    for effect in &mut effects {
        effect.range = effect.range_over(&subject.data.subset(&kept), &subject.environment.condition_kinds);
    }
    let gains = if withdrawn { gains.without_causes() } else { gains };
    let (before, after) = [without, judged].map(|m| rms(m.table(), &m.residual, &kept)).into();
    let undecided = match causes.is_empty() && unknown.is_none() {
        // What is left of rows that were fitted is smaller than the noise by the share of the parameters.
        true => undecided(&gains, &after, (judged.kept.count() as f64 / (judged.noise.dof * judged.inflation)).sqrt()),
        false => None,
    };
    let step = judged.step();
    let specs = subject.mechanism.parameters().len();
    Ok(Diagnosis {
        verdict: verdict(&causes, unknown.as_ref(), undecided.as_ref()),
        undecided,
        misread: None,
        outlier_rows: state.kept().left_out.iter().map(|k| subject.data.sample(*k).row).collect(),
        residuals: joint_residuals(subject, without, judged),
        noise_varies: state.noise_varies.clone(),
        correlation: state.correlation,
        gain: gains,
        not_found,
        not_testable,
        before,
        after,
        noise_scale: judged.noise.variance().sqrt() * state.spreads.kinds.map_or(1.0, |[p, r]| (p * r).sqrt()),
        samples: subject.data.len(),
        joints: subject.mechanism.joints().iter().map(|j| j.name.clone()).collect(),
        values: state.point.values.iter().zip(step.iter()).map(|(v, d)| v + d).collect(),
        own: model.table().own.iter().zip(step.iter().skip(specs)).map(|(v, d)| v + d).collect(),
        effects,
        environment: (*subject.environment).clone(),
        frames: registration.frames,
        warnings: warnings(subject, state, unknown.as_ref()),
        causes,
        unknown,
    })
}

/// What the tests together say.
struct Conclusion {
    causes: Vec<Cause>,
    unknown: Option<Unknown>,
    /// True if the names of the search do not hold.
    withdrawn: bool,
}

impl Conclusion {
    /// The names do not hold; instead there is this.
    fn withdraw(&mut self, found: Unknown) {
        let names = self.causes.drain(..).map(|c| c.effect).collect();
        self.withdrawn = true;
        self.unknown = Some(Unknown { withdrawn: names, ..found });
    }
}

/// Judges the names that the search found by what they leave.
fn conclude(
    subject: &Hypotheses<'_>,
    state: &SearchState,
    without: &Model,
    (gains, unseen): (&Gain, &Unseen),
) -> Result<Conclusion, DiagnoseError> {
    let (model, names) = (&state.model, state.names());
    let known = covariates(subject.data, &subject.environment.condition_kinds);
    let everything = with_coordinates(&known, subject);
    let mut told = Conclusion {
        causes: causes(subject, state, model, unseen)?,
        unknown: remainder(model, &everything).filter(|u| !is_rounding(without, model, u.leg)),
        withdrawn: false,
    };
    if !names.is_empty() {
        let worth = worth_of(without, &subject.groups, names) - price_of_places(subject, names);
        if let Some(found) = rival(without, &known, worth, TIED) {
            told.withdraw(found);
        }
    }
    if told.unknown.is_none() && (patchwork(subject, names) || one_motion(&told.causes)) {
        // Jumps and drifts stacked on each other describe anything that changes with time.
        told.unknown = Some(Unknown {
            covariate: Some(if known.iter().any(|c| c.name == TIME) { TIME.into() } else { "row".into() }),
            ..Unknown::by(UnknownTest::Patchwork, told.causes.iter().map(|c| c.p_value).fold(0.0, f64::max))
        });
    }
    if let Some(test) = harms(&told.causes, gains).filter(|_| !told.withdrawn) {
        told.withdraw(remainder(without, &everything).unwrap_or_else(|| Unknown::by(test, 0.0)));
    }
    if subject.data.noise.known && is_hopeless(subject, if told.withdrawn { without } else { model }) {
        told.withdraw(Unknown::by(UnknownTest::Misfit, 0.0));
    }
    // Beside samples that repeat each other, rows that go together are what is not modelled, and no memory of the noise.
    let model = &state.with_independent_rows(subject, names.to_vec())?;
    let without = &state.with_independent_rows(subject, Vec::new())?;
    if let Some(lack) = LackOfFit::of(model, subject.data, &subject.environment.condition_kinds) {
        let found = beside_repeats(model, everything, told.unknown.take(), &lack);
        if !told.withdrawn && !names.is_empty() && lack.chance_of(without, &subject.groups, names) > LEVEL {
            told.withdraw(found);
        } else {
            told.unknown = Some(found);
        }
    }
    if told.unknown.is_none() && told.causes.is_empty() && subject.data.noise.known {
        told.unknown = noise_exceeded(&state.model, &state.spreads);
    }
    told.unknown = told.unknown.map(|u| Unknown { dimension: dimension(subject, &u), ..u });
    Ok(told)
}

/// What is left where repeated samples say that something is. What comes again with the same commands and conditions does not
/// depend on the time.
fn beside_repeats(model: &Model, everything: Vec<Covariate>, unknown: Option<Unknown>, lack: &LackOfFit) -> Unknown {
    let is_timeless = |name: &str| name != TIME && name != "row";
    let timeless: Vec<Covariate> = everything.into_iter().filter(|c| is_timeless(&c.name)).collect();
    unknown
        .filter(|u| u.covariate.as_deref().is_none_or(is_timeless))
        .or_else(|| most_telling(model, &timeless, lack.p_value))
        .unwrap_or_else(|| Unknown { size: Some(lack.times), ..Unknown::by(UnknownTest::Repeats, lack.p_value) })
}

/// The dimension of what acts where an unknown error acts.
fn dimension(subject: &Hypotheses<'_>, unknown: &Unknown) -> Dimension {
    match (unknown.leg, unknown.coordinate) {
        (Some(joint), _) => subject.mechanism.joints()[joint].dimension,
        (None, Some(0..3)) => Dimension::Length,
        (None, Some(_)) => Dimension::Angle,
        (None, None) => Dimension::None,
    }
}

/// A value this many usual sizes large is none of the effect, whatever fits.
const ABSURD: f64 = 300.0;
/// Names that make rows of a block that was not fitted this many times worse are wrong, or known too badly to be used.
const WORSE: f64 = 3.0;

/// Whether names would do harm: by values that do not exist, or by what they make of rows that were not fitted.
fn harms(causes: &[Cause], gains: &Gain) -> Option<UnknownTest> {
    let absurd = |c: &Cause| c.parameters.iter().any(|p| p.value.abs() > ABSURD * p.scale);
    let worse =
        |before: Option<f64>, after: Option<f64>| matches!((before, after), (Some(b), Some(a)) if a > WORSE * b);
    // Without the block before it a step is not seen at all.
    let steps = causes.iter().any(|c| c.row.is_some());
    let in_blocks = !steps
        && (worse(gains.blocked_position_before, gains.blocked_position_after)
            || worse(gains.blocked_rotation_before, gains.blocked_rotation_after));
    let at_random =
        worse(gains.position_before, gains.position_after) || worse(gains.rotation_before, gains.rotation_after);
    if causes.is_empty() {
        None
    } else if causes.iter().any(absurd) {
        Some(UnknownTest::Misfit)
    } else {
        (in_blocks || at_random).then_some(UnknownTest::Extrapolation)
    }
}

/// Errors on rows that were not fitted this many times the noise that the fitted ones show, or the stated one, mean that the
/// rows hardly decide the parameters.
const UNHELD: f64 = 3.0;

/// Why the data cannot tell whether there is anything, if they cannot. The noise is `per_residual` times what is left.
fn undecided(gains: &Gain, left: &ErrorSummary, per_residual: f64) -> Option<String> {
    let pairs = [(gains.position_before, left.position), (gains.rotation_before, left.rotation)];
    if pairs.iter().all(|(held_out, _)| held_out.is_none()) {
        return Some(
            "without a fifth of the rows the others do not decide the parameters, so that nothing can be checked on rows that \
             were not fitted: measure more, and more varied, poses"
                .into(),
        );
    }
    let floors = [gains.noise_floor_position, gains.noise_floor_rotation];
    let far = pairs.iter().zip(floors).any(|((held_out, left), floor)| match (held_out, left) {
        (Some(held_out), Some(left)) => *held_out > UNHELD * (left * per_residual).max(floor.unwrap_or(0.0)),
        _ => false,
    });
    far.then(|| {
        "rows that were not fitted are missed by more than three times the noise: there are too few rows for so many \
         parameters; measure more, and more varied, poses"
            .into()
    })
}

fn verdict(causes: &[Cause], unknown: Option<&Unknown>, undecided: Option<&String>) -> Verdict {
    match unknown {
        _ if undecided.is_some() => Verdict::Undecided,
        Some(_) => Verdict::Unknown,
        None if causes.is_empty() => Verdict::Clean,
        None if causes.iter().any(|c| !c.tied_with.is_empty()) => Verdict::Tied,
        None => Verdict::Named,
    }
}

/// What the user should know of noise and tolerances.
fn warnings(subject: &Hypotheses<'_>, state: &SearchState, unknown: Option<&Unknown>) -> Vec<String> {
    let mut warnings = Vec::new();
    // What depends on something changes the ratio too.
    let is_noise = unknown.is_none_or(|u| u.kind() == "noise");
    if let Some([position, rotation]) = state.spreads.kinds.filter(|_| is_noise) {
        warnings.push(format!(
            "the ratio of position noise to rotation noise is {} times the stated one; rows are weighted by the \
             estimated noise",
            three_digits(position / rotation)
        ));
    }
    if subject.mechanism.parameters().iter().all(|p| p.tolerance.is_none()) {
        warnings.push("the mechanism file states no [tolerance]; parameters are only kept finite".into());
    }
    warnings
}

/// True if what is left at a joint is less than the digits that any file has.
fn is_rounding(without: &Model, model: &Model, joint: Option<usize>) -> bool {
    let of = |m: &Model| m.table().spreads_of(&m.residual, m.kept.rows());
    joint.is_some_and(|k| of(model)[k] < ROUNDING * of(without)[k])
}

/// True if what is left is far above the stated noise.
fn is_hopeless(subject: &Hypotheses<'_>, model: &Model) -> bool {
    let left = rms(model.table(), &model.residual, &model.kept.samples());
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
        |name: &&Hypothesis| group(name).effect.covariates(&group(name).places[name.place].at).contains(&TIME.into());
    names.iter().enumerate().any(twice) || names.iter().filter(about_time).count() >= 3
}

/// Cosine of the directions of two motions from which on they are one: of two causes of six values each, 0.6 in 100 pairs agree
/// so well.
const ONE_DIRECTION: f64 = 0.9;

/// True if two names move the frame of the instrument in one direction: something else moves it, with a course in time that
/// neither has.
fn one_motion(causes: &[Cause]) -> bool {
    let motion = |c: &Cause| -> Option<Vec<f64>> {
        let rigid = c.acts_on == ActsOn::Measurement && c.parameters.len() == 6;
        rigid.then(|| c.parameters.iter().map(|p| p.value / p.scale).collect())
    };
    let motions: Vec<Vec<f64>> = causes.iter().filter_map(motion).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let together = |a: &[f64], b: &[f64]| dot(a, b).powi(2) > ONE_DIRECTION.powi(2) * dot(a, a) * dot(b, b);
    motions.iter().enumerate().any(|(k, a)| motions[..k].iter().any(|b| together(a, b)))
}

/// What it costs, in nats, to choose the places of names.
fn price_of_places(subject: &Hypotheses<'_>, names: &[Hypothesis]) -> f64 {
    let places = |name: &Hypothesis| {
        let group = &subject.groups[name.group];
        group.places.len() * name.from.map_or(1, |_| subject.data.len())
    };
    names.iter().map(|name| (places(name) as f64).ln()).sum()
}

/// Effects that were not found with their limits, and those that these data cannot see.
fn not_found(
    subject: &Hypotheses<'_>,
    model: &Model,
    without: &Model,
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
            None => unseen.push(group.unchanging()),
        }
    }
    (found, unseen)
}

fn gain(question: &Question<'_>, without: &Model, with: &Model, kept: &[usize]) -> Gain {
    let random = folds(kept, Some(question.seed));
    let blocks = folds(kept, None);
    let (before, blocked_before) = (held_out(without, &random), held_out(without, &blocks));
    let (after, blocked_after) = match std::ptr::eq(without, with) {
        true => (before, blocked_before),
        false => (held_out(with, &random), held_out(with, &blocks)),
    };
    let noise = &question.data.noise;
    let floor = |sigma: f64| noise.known.then(|| 3.0_f64.sqrt() * sigma);
    Gain {
        position_before: before.and_then(|e| e.position),
        position_after: after.and_then(|e| e.position),
        rotation_before: before.and_then(|e| e.rotation),
        rotation_after: after.and_then(|e| e.rotation),
        blocked_position_before: blocked_before.and_then(|e| e.position),
        blocked_position_after: blocked_after.and_then(|e| e.position),
        blocked_rotation_before: blocked_before.and_then(|e| e.rotation),
        blocked_rotation_after: blocked_after.and_then(|e| e.rotation),
        noise_floor_position: floor(noise.position),
        noise_floor_rotation: floor(noise.rotation),
    }
}
