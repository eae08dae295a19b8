//! The whole job: frames, prior, identification, judgement.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use crate::identification::calibration::{Calibration, CalibrationOptions};
use crate::identification::carried::{Carried, carried, carried_workspace};
use crate::identification::error::IdentifyError;
use crate::identification::estimators::fit::Fit;
use crate::identification::estimators::identification::Identification;
use crate::identification::estimators::identifiers::Identifier;
use crate::identification::judgement::drawing::{DrawingTest, widened};
use crate::identification::judgement::goodness_of_fit::GoodnessOfFit;
use crate::identification::judgement::held_out::{Holdout, held_out, held_out_data};
use crate::identification::judgement::kinds::noise_of_kinds;
use crate::identification::judgement::model_errors::{ErrorSummary, errors_at, evaluate};
use crate::identification::judgement::prediction::{predicted_errors, predicted_errors_as_seen, visible_directions};
use crate::identification::judgement::verdict::{
    judge, judge_commands, judge_drawing, judge_held_out, judge_poses, judge_prediction,
};
use crate::identification::judgement::warnings::with_warnings;
use crate::identification::judgement::weak_directions::weak_directions;
use crate::identification::problem::belief::{Belief, Conventions, group_of, without_conventions};
use crate::identification::problem::calibration_problem::CalibrationProblem;
use crate::identification::problem::prior::{Prior, PriorPolicy};
use crate::identification::problem::start::poses_from_home;
use crate::identification::registration::{Registration, register, register_poses};
use crate::identification::task::Task;
use crate::measurement::{Dataset, Free, RowKind, TargetFrame, UnknownFrames};
use crate::mechanism::{Body, Mechanism, Workspace, characteristic_length, not_carried};
use crate::observability::PredictedError;
use crate::pose::{Pose, PoseConvention};

const PREDICTED_POSES: usize = 200;
/// Rounds of finding frames and parameters in turn.
const FRAME_ROUNDS: usize = 8;
/// A misfit as likely as this needs no better frames.
const FITS: f64 = 1e-3;

/// Calibrates `mechanism` with `data`.
///
/// # Errors
/// [`IdentifyError`] if there is no result at all; one that must not be trusted is returned with its verdict.
pub fn calibrate(
    mechanism: &dyn Mechanism,
    data: &Dataset,
    workspace: Option<&Workspace>,
    identifier: &dyn Identifier,
    options: &CalibrationOptions,
) -> Result<Calibration, IdentifyError> {
    let nominal = poses_from_home(mechanism, data);
    let mut solved = identified(mechanism, data, &nominal, options, identifier)?;
    // Without a stated noise the first fit tells how positions and angles compare.
    let rescaled;
    let data = match noise_of_kinds(&solved.problem, &solved.fit) {
        Some(scales) => {
            rescaled = data.with_noise_of_kinds(scales);
            solved = identified(mechanism, &rescaled, &nominal, options, identifier)?;
            &rescaled
        }
        None => data,
    };
    let Solved { registration: stood, mut problem, fit, converged, free } = solved;
    let as_seen = Identification::of(&mut problem, &fit)?;
    // What the frames moved by belongs to them from here on.
    let (found, moved) = as_seen.clone().without_last(free.count());
    let registration = Registration { frames: free.moved(&stood.frames, &moved), ..stood };
    let frames = registration.frames;
    let Carried { mechanism: calibrated, parameters, covariance, plausibility } = carried(mechanism, &found, &frames)?;
    let own = found.own_values();
    let held_out = match &options.holdout {
        Holdout::Data(other) => {
            let other = UnknownFrames::wrap(&other.with_frames(stood.frames), &free);
            Some(held_out_data(&as_seen, mechanism, &other)?)
        }
        holdout => held_out(identifier, &problem, &fit, holdout, options.seed)?,
    };
    let tolerance_factors = problem.belief().factors;
    let rows = problem.at_start()?;
    let wider: Vec<f64> = mechanism.parameters().iter().map(|s| tolerance_factors[group_of(s.role)]).collect();
    let rank = found.prior.then(|| rows.rank());
    let weak = if rows.without_weakness(found.noise_scale) {
        Vec::new()
    } else {
        weak_directions(mechanism, &rows.spectrum().for_noise(found.noise_scale))
    };
    let drawing = DrawingTest::of(&problem, &fit)?;
    let mut verdict = judge(mechanism, data, &found, converged);
    judge_drawing(&mut verdict, drawing.as_ref(), tolerance_factors, options.prior);
    let (poses, convention) = poses_to_predict(&found, workspace, options);
    if let Some(rank) = rank.filter(|rank| 2 * rank < found.mechanism_parameters) {
        judge_poses(&mut verdict, rank, visible_directions(mechanism, &wider, &poses, &convention));
    }
    // An absurd model, from data that were misread, may not lead from its own home to its own samples.
    let after = evaluate(calibrated.as_ref(), &own, data).map_or_else(
        |cause| {
            verdict.distrust(format!("the calibrated model does not reach its own samples ({cause})"));
            ErrorSummary::default()
        },
        |errors| errors.rms(),
    );
    let in_frames = data.with_frames(stood.frames);
    let not_reached = nominal.iter().filter(|pose| pose.is_err()).count();
    let nominal: Option<Vec<Pose>> = nominal.into_iter().collect::<Result<_, _>>().ok();
    // Two frames may move against each other without anything to be seen; the parameters may not.
    let determined = found.parameters.iter().all(|p| p.sigma.is_some());
    let predicted = predict(mechanism, problem.data(), &as_seen, determined, &poses, &convention)?;
    let predicted = predicted.and_then(|p| Some(p.times(found.misfit.widening()?)));
    // What is to be learned beyond placing the machine.
    let of_drawing = without_conventions(mechanism, tolerance_factors)
        .and_then(|covariance| predicted_errors(mechanism, &covariance, &poses, &convention));
    if let Some(predicted) = &predicted {
        let mut measured = after;
        // Two angles of three leave the attitude open.
        measured.rotation = after.rotation.filter(|_| (0..data.len()).any(|k| angles(data, k) >= 3));
        judge_prediction(&mut verdict, predicted, of_drawing.as_ref(), &measured, characteristic_length(mechanism));
    }
    judge_commands(&mut verdict, data);
    if let Some(held_out) = &held_out {
        judge_held_out(&mut verdict, held_out, &after, &found.misfit, data.row_count());
    }
    let result = Calibration {
        measurement: data.model().describe(),
        nuisance_heading: data.model().nuisance_heading(),
        identifier: identifier.name().to_owned(),
        before: nominal.map(|poses| errors_at(&poses, &[], &in_frames).rms()).unwrap_or_default(),
        not_reached,
        after,
        held_out,
        predicted,
        of_drawing,
        drawing,
        tolerance_factors,
        weak,
        plausibility,
        workspace: workspace.map(|w| carried_workspace(w, &frames)),
        verdict,
        mechanism: calibrated,
        parameters,
        covariance,
        identification: found,
        converged,
        registration,
    };
    Ok(with_warnings(result, data, &options.holdout))
}

/// How many angles of a sample were measured.
fn angles(data: &Dataset, k: usize) -> usize {
    data.rows(k).into_iter().filter(|kind| *kind == RowKind::Rotation).count()
}

/// What was found, in which frames.
struct Solved<'a> {
    registration: Registration,
    problem: CalibrationProblem<'a>,
    fit: Fit,
    converged: bool,
    /// Motions of the frames that are unknowns of the problem.
    free: Free,
}

/// The fit of a problem, and whether it converged; where it does not from one start, it may from another.
fn estimated(identifier: &dyn Identifier, problem: &mut CalibrationProblem<'_>) -> Result<(Fit, bool), IdentifyError> {
    let failure = match identifier.estimate(problem) {
        Ok(fit) => return Ok((fit, true)),
        Err(error @ (IdentifyError::NotConverged { .. } | IdentifyError::Solve(_))) => error,
        Err(error) => return Err(error),
    };
    if problem.begin_at_closure()
        && let Ok(fit) = identifier.estimate(problem)
    {
        return Ok((fit, true));
    }
    match failure {
        IdentifyError::NotConverged { last, .. } => Ok((*last, false)),
        error => Err(error),
    }
}

/// Frames found with the drawing and, while the data do not fit, again with the mechanism that was identified in them. A
/// platform that hardly turns shows where the target sits on it only by the tilts that its own errors cause.
fn identified<'a>(
    mechanism: &'a dyn Mechanism,
    data: &Dataset,
    nominal: &[Result<Pose, IdentifyError>],
    options: &CalibrationOptions,
    identifier: &dyn Identifier,
) -> Result<Solved<'a>, IdentifyError> {
    let solve =
        |registration: Registration, conventions: Conventions, free: &Free| -> Result<Solved<'a>, IdentifyError> {
            let aligned = UnknownFrames::wrap(&data.with_frames(registration.frames), free);
            let task =
                Task { prior: options.prior, weights: options.weights, conventions, ..Task::new(mechanism, &aligned) };
            let mut problem = CalibrationProblem::from_poses(mechanism, &task, nominal.to_vec())?;
            let (fit, converged) = estimated(identifier, &mut problem)?;
            Ok(Solved { registration, problem, fit, converged, free: free.clone() })
        };
    let frames = Conventions { tracker: true, target: !places_are_identified(data), zeros: false };
    let mut tried = register_poses(mechanism, data, nominal);
    // A mechanism that carries its points takes the frames up in them.
    if !tried.applied || mechanism.mounted(&Pose::identity(), &Pose::identity()).is_none() {
        let conventions = if tried.frames.is_identity() { Conventions::STATED } else { frames };
        return as_found(solve(tried, conventions, &Free::default())?, identifier);
    }
    let free = unknown_motions(mechanism, data);
    let solve = |registration: Registration| solve(registration, frames, &free);
    let (mut best, mut least) = (None, f64::INFINITY);
    for _ in 0..FRAME_ROUNDS {
        let found = solve(tried)?;
        let misfit = GoodnessOfFit::of(&found.problem, &found.fit)?;
        if best.is_some() && !(misfit.chi_square < least) {
            break;
        }
        least = misfit.chi_square;
        let fits = misfit.p_value().is_none_or(|p| p > FITS);
        let values = found.fit.values.as_slice()[..found.problem.mechanism_parameters()].to_vec();
        best = Some(found);
        if fits {
            break;
        }
        tried = register(mechanism.with_values(&values, mechanism.home())?.as_ref(), data);
        if !tried.applied {
            break;
        }
    }
    // The first round always leaves one.
    as_found(best.ok_or(IdentifyError::Empty)?, identifier)
}

/// The motions of tracker and target that the points of a mechanism cannot take up, as far as readings tell of them.
fn unknown_motions(mechanism: &dyn Mechanism, data: &Dataset) -> Free {
    let plain = mechanism.extension().map_or(mechanism, |e| e.inner());
    let mut target = match data.model().target_frame() {
        TargetFrame::Convention => not_carried(plain, Body::Platform),
        _ => Vec::new(),
    };
    // How a target is turned is seen by attitudes alone.
    let attitudes = (0..data.len()).any(|k| angles(data, k) >= 3);
    target.retain(|k| *k < 3 || attitudes);
    Free { tracker: not_carried(plain, Body::Base), target }
}

/// Where the targets sit on the platform is identified, so that moving them and the platform's points together moves nothing
/// that is measured; the drawing says where the platform is.
fn places_are_identified(data: &Dataset) -> bool {
    data.model().target_frame() == TargetFrame::Identified
}

/// Rounds of freeing conventions and widening tolerances.
const BELIEFS: usize = 6;

/// A fit whose prior the data do not contradict: conventions that are not those of the drawing are freed, and then the
/// tolerances are widened by as much as the data ask for.
fn as_found<'a>(mut found: Solved<'a>, identifier: &dyn Identifier) -> Result<Solved<'a>, IdentifyError> {
    for _ in 0..BELIEFS {
        if !found.problem.prior().is_some_and(Prior::informs) || !found.converged {
            break;
        }
        let Some(belief) = contradicted(&found)? else { break };
        found.problem.believe(belief);
        found.problem.begin_at(found.fit.values);
        (found.fit, found.converged) = estimated(identifier, &mut found.problem)?;
    }
    Ok(found)
}

/// How the tolerances are to be taken instead, if the data contradict them as they were.
fn contradicted(found: &Solved<'_>) -> Result<Option<Belief>, IdentifyError> {
    let (problem, mechanism) = (&found.problem, found.problem.mechanism());
    let belief = problem.belief();
    let values = &found.fit.values.as_slice()[..problem.mechanism_parameters()];
    let centre = belief.centre.as_deref().unwrap_or_else(|| mechanism.values());
    let mut seen = Conventions::contradicted(mechanism, centre, values, 1.0);
    seen.target &= !places_are_identified(problem.data());
    // A convention that is free is looked for about where it was found: the first fit may have been pulled back from there.
    if seen != Conventions::STATED {
        let conventions = belief.conventions.or(seen);
        return Ok(Some(Belief { conventions, centre: Some(values.to_vec()), ..belief.clone() }));
    }
    let doubted = DrawingTest::of(problem, &found.fit)?.and_then(|test| test.p_value()).is_some_and(|p| p < FITS);
    if problem.policy() != PriorPolicy::Auto || !doubted {
        return Ok(None);
    }
    let factors = widened(problem, &found.fit)?;
    let wider = factors.iter().zip(belief.factors).any(|(next, now)| next / now > WIDER);
    Ok(wider.then(|| Belief { factors, ..belief.clone() }))
}

/// A factor that grows by less is not worth another fit.
const WIDER: f64 = 1.02;

/// The poses at which errors are predicted, and how they are stated.
fn poses_to_predict(
    found: &Identification,
    workspace: Option<&Workspace>,
    options: &CalibrationOptions,
) -> (Vec<Pose>, PoseConvention) {
    match workspace {
        Some(w) => {
            let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
            ((0..PREDICTED_POSES).map(|_| w.random(&mut rng)).collect(), w.convention)
        }
        None => (found.poses.clone(), options.convention),
    }
}

/// Of what an instrument sees, where `data` have parameters for the place of its frames or of the targets.
fn predict(
    mechanism: &dyn Mechanism,
    data: &Dataset,
    found: &Identification,
    determined: bool,
    poses: &[Pose],
    convention: &PoseConvention,
) -> Result<Option<PredictedError>, IdentifyError> {
    if !determined {
        return Ok(None);
    }
    let aligned = mechanism.with_values(&found.mechanism_values(), mechanism.home())?;
    let pivot = data.frames.target.place(&convention.pivot);
    let convention = PoseConvention { pivot, ..*convention };
    let (aligned, own) = (aligned.as_ref(), found.own_values());
    let motion = |pose: &Pose| data.model().platform_motion(&own, pose, &data.frames);
    Ok(match motion(&mechanism.home()) {
        Some(_) => predicted_errors_as_seen(aligned, &found.covariance, motion, poses, &convention),
        None => predicted_errors(aligned, &found.mechanism_covariance(), poses, &convention),
    })
}
