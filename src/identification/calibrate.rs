//! The whole job: frames, prior, identification, judgement.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use crate::identification::calibration::{Calibration, CalibrationOptions};
use crate::identification::carried::{Carried, carried, carried_workspace};
use crate::identification::error::IdentifyError;
use crate::identification::estimators::identification::Identification;
use crate::identification::estimators::identifiers::Identifier;
use crate::identification::judgement::held_out::{HeldOut, Holdout, held_out};
use crate::identification::judgement::model_errors::{ErrorSummary, evaluate};
use crate::identification::judgement::prediction::predicted_errors;
use crate::identification::judgement::verdict::judge;
use crate::identification::judgement::warnings::with_warnings;
use crate::identification::judgement::weak_directions::{DataSpectrum, weak_directions};
use crate::identification::problem::prior::{FrameConvention, frames_differ};
use crate::identification::registration::{Registration, register};
use crate::identification::task::Task;
use crate::measurement::{Dataset, Frames};
use crate::mechanism::{Mechanism, Workspace};
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
    let identify = |task: &Task<'_>| match identifier.identify(task) {
        Ok(found) => Ok((found, true)),
        Err(IdentifyError::NotConverged { last, .. }) => Ok((*last, false)),
        Err(error) => Err(error),
    };
    let (registration, identified) = settled_registration(mechanism, data, options, &identify)?;
    let frames = registration.frames;
    let aligned = data.with_frames(frames);
    let convention = if frames.is_identity() { FrameConvention::Stated } else { FrameConvention::Free };
    let mut task =
        Task { prior: options.prior, weights: options.weights, convention, ..Task::new(mechanism, &aligned) };
    let (mut found, mut converged) = match identified {
        Some(identified) => identified,
        None => identify(&task)?,
    };
    if found.prior && convention == FrameConvention::Stated && frames_differ(mechanism, &found.mechanism_values()) {
        // The tracker or the target is a little off: too little to be registered, too much for the tolerances.
        task.convention = FrameConvention::Free;
        (found, converged) = identify(&task)?;
    }
    let Carried { mechanism: calibrated, parameters, covariance, plausibility } = carried(mechanism, &found, &frames)?;
    let own = found.own_values();
    let held_out = match &options.holdout {
        Holdout::Data(other) => {
            let errors = evaluate(calibrated.as_ref(), &own, other).map_err(|e| IdentifyError::HeldOut(Box::new(e)))?;
            Some(HeldOut { rms: errors.rms(), samples: errors.samples.len() })
        }
        holdout => held_out(identifier, &task, holdout, options.seed)?,
    };
    let spectrum = DataSpectrum::at_start(&task, found.noise_scale)?;
    let mut verdict = judge(mechanism, data, &found, converged);
    // An absurd model, from data that were misread, may not lead from its own home to its own samples.
    let after = evaluate(calibrated.as_ref(), &own, data).map_or_else(
        |cause| {
            verdict.distrust(format!("the calibrated model does not reach its own samples ({cause})"));
            ErrorSummary::default()
        },
        |errors| errors.rms(),
    );
    let result = Calibration {
        measurement: data.model().describe(),
        nuisance_heading: data.model().nuisance_heading(),
        identifier: identifier.name().to_owned(),
        before: evaluate(mechanism, &[], data)?.rms(),
        after,
        held_out,
        predicted: predict(mechanism, &found, workspace, &frames, options)?,
        weak: weak_directions(mechanism, &spectrum),
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

/// Gives an identification, and whether it converged.
type Identify<'a> = dyn Fn(&Task<'_>) -> Result<(Identification, bool), IdentifyError> + 'a;

/// Frames found with the drawing and, while the data do not fit, again with the mechanism that was identified in them. A
/// platform that hardly turns shows where the target sits on it only by the tilts that its own errors cause. With the frames
/// comes what was identified in them, if anything was.
fn settled_registration(
    mechanism: &dyn Mechanism,
    data: &Dataset,
    options: &CalibrationOptions,
    identify: &Identify<'_>,
) -> Result<(Registration, Option<(Identification, bool)>), IdentifyError> {
    let (mut best, mut identified) = (register(mechanism, data)?, None);
    let mut least = f64::INFINITY;
    let mut tried = best;
    for _ in 0..FRAME_ROUNDS {
        // A mechanism that carries its points takes the frames up in them.
        if !tried.applied || mechanism.mounted(&Pose::identity(), &Pose::identity()).is_none() {
            break;
        }
        let aligned = data.with_frames(tried.frames);
        let (prior, weights, convention) = (options.prior, options.weights, FrameConvention::Free);
        let (found, converged) = identify(&Task { prior, weights, convention, ..Task::new(mechanism, &aligned) })?;
        let misfit = found.misfit.chi_square;
        if !(misfit < least) {
            break;
        }
        let fits = found.misfit.p_value().is_none_or(|p| p > FITS);
        let values = found.mechanism_values();
        (best, least, identified) = (tried, misfit, Some((found, converged)));
        if fits {
            break;
        }
        tried = register(mechanism.with_values(&values, mechanism.home())?.as_ref(), data)?;
    }
    Ok((best, identified))
}

fn predict(
    mechanism: &dyn Mechanism,
    found: &Identification,
    workspace: Option<&Workspace>,
    frames: &Frames,
    options: &CalibrationOptions,
) -> Result<Option<PredictedError>, IdentifyError> {
    if found.parameters.iter().any(|p| p.sigma.is_none()) {
        return Ok(None);
    }
    let aligned = mechanism.with_values(&found.mechanism_values(), mechanism.home())?;
    let (poses, convention) = match workspace {
        Some(w) => {
            let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
            ((0..PREDICTED_POSES).map(|_| w.random(&mut rng)).collect(), w.convention)
        }
        None => (found.poses.clone(), options.convention),
    };
    let pivot = frames.target.place(&convention.pivot);
    let convention = PoseConvention { pivot, ..convention };
    Ok(predicted_errors(aligned.as_ref(), &found.mechanism_covariance(), &poses, &convention))
}
