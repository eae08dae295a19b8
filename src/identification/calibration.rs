//! The whole job: frames, prior, identification, judgement.

use nalgebra::{DMatrix, Vector3};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use crate::identification::judgement::held_out::held_out;
use crate::identification::judgement::model_errors::{ErrorSummary, evaluate};
use crate::identification::judgement::prediction::predicted_errors;
use crate::identification::judgement::verdict::{CalibrationVerdict, judge, with_warnings};
use crate::identification::judgement::weak_directions::{DataSpectrum, WeakDirection, weak_directions};
use crate::identification::{
    Estimate, FrameConvention, HeldOut, Holdout, Identification, Identifier, IdentifyError, Plausibility, PriorPolicy,
    Registration, Task, Weights, frames_differ, plausibility, register,
};
use crate::measurement::{Dataset, Frames};
use crate::mechanism::{Body, Mechanism, Workspace};
use crate::observability::PredictedError;
use crate::pose::{Pose, PoseConvention};

/// Options of a calibration.
#[derive(Clone, Debug)]
pub struct CalibrationOptions {
    /// Where priors come from.
    pub prior: PriorPolicy,
    /// How to weight the rows.
    pub weights: Weights,
    /// Which rows are held out to measure the errors.
    pub holdout: Holdout,
    /// Seed of the folds and of the poses at which errors are predicted.
    pub seed: u64,
    /// Whose pivot is meant by the position of a pose, where there is no workspace that says so.
    pub convention: PoseConvention,
}

impl Default for CalibrationOptions {
    fn default() -> Self {
        Self {
            prior: PriorPolicy::Auto,
            weights: Weights::Noise,
            holdout: Holdout::Folds(5),
            seed: 0,
            convention: PoseConvention::default(),
        }
    }
}

/// A calibrated mechanism and how far to trust it.
#[derive(Debug)]
pub struct Calibration {
    /// The calibrated mechanism, in the frames of the measurement.
    pub mechanism: Box<dyn Mechanism>,
    /// Its parameters, then those of the measurement, in the frames of the measurement; those of a mechanism that is
    /// mounted in them ([`Mechanism::mounted`]) in the frames of its drawing.
    pub parameters: Vec<Estimate>,
    /// Covariance of the mechanism's parameters, in the same frames.
    pub covariance: DMatrix<f64>,
    /// Result of the identifier, in the frames of the nominal mechanism.
    pub identification: Identification,
    /// True if the iteration converged.
    pub converged: bool,
    /// Where the tracker and the target were found before the identification.
    pub registration: Registration,
    /// The workspace in the frames of the measurement.
    pub workspace: Option<Workspace>,
    /// RMS errors of the mechanism as it was given.
    pub before: ErrorSummary,
    /// RMS errors of the calibrated mechanism on the rows that were fitted.
    pub after: ErrorSummary,
    /// RMS errors on rows that were not fitted.
    pub held_out: Option<HeldOut>,
    /// Predicted error over the workspace, or over the measured poses without one.
    pub predicted: Option<PredictedError>,
    /// Directions that the data do not decide.
    pub weak: Vec<WeakDirection>,
    /// Rigid motions, leg offsets, and what is left against the tolerances.
    pub plausibility: Plausibility,
    /// May it be used?
    pub verdict: CalibrationVerdict,
}

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
    // Mounted in the frames of the measurement a mechanism keeps the parameters of its drawing; others carry them there.
    let fitted = mechanism.with_values(&found.mechanism_values(), mechanism.home())?;
    let mounted = fitted.mounted(&frames.base, &frames.target).filter(|_| !frames.is_identity());
    let is_mounted = mounted.is_some();
    let carried = if is_mounted { Frames::default() } else { frames };
    let (parameters, covariance) = carry(mechanism, &found, &carried);
    let values: Vec<f64> = parameters[..found.mechanism_parameters].iter().map(|p| p.value).collect();
    let calibrated = match mounted {
        Some(mounted) => mounted,
        None => mechanism.with_values(&values, frames.measured(&mechanism.home()))?,
    };
    let own = found.own_values();
    let held = match &options.holdout {
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
        before: evaluate(mechanism, &[], data)?.rms(),
        after,
        held_out: held,
        predicted: predict(mechanism, &found, workspace, &frames, options)?,
        weak: weak_directions(mechanism, &spectrum),
        plausibility: if is_mounted {
            plausibility(mechanism, &values).seen_from(&frames)
        } else {
            plausibility(mechanism, &values)
        },
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

/// Parameters and covariance in the frames of the measurement: `b' = B b`, `a' = A⁻¹ a`.
fn carry(mechanism: &dyn Mechanism, found: &Identification, frames: &Frames) -> (Vec<Estimate>, DMatrix<f64>) {
    let n = found.mechanism_parameters;
    let mut parameters = found.parameters.clone();
    let mut covariance = found.mechanism_covariance();
    if frames.is_identity() {
        return (parameters, covariance);
    }
    let specs = mechanism.parameters();
    let values = found.mechanism_values();
    let mut map = DMatrix::identity(n, n);
    for (body, motion) in [(Body::Base, frames.base), (Body::Platform, frames.target.inverse())] {
        let points = body.points(mechanism, &values);
        let member = |k: usize| body.coordinate(specs[k].role);
        for k in 0..n {
            let Some((leg, axis)) = member(k) else { continue };
            let point = points.iter().find(|(l, _)| *l == leg).map_or(Vector3::zeros(), |(_, p)| *p);
            parameters[k].value = motion.place(&point)[axis];
            for j in 0..n {
                if let Some((_, from)) = member(j).filter(|(l, _)| *l == leg) {
                    map[(k, j)] = motion.rotation[(axis, from)];
                }
            }
        }
    }
    covariance = &map * covariance * map.transpose();
    let known: Vec<bool> = found.parameters.iter().map(|p| p.sigma.is_some()).collect();
    for (k, p) in parameters.iter_mut().take(n).enumerate() {
        // A coordinate is known if all those of its point that it is turned from are.
        let all_known = (0..n).all(|j| map[(k, j)].abs() < 1e-12 || known[j]);
        p.sigma = all_known.then(|| covariance[(k, k)].max(0.0).sqrt());
    }
    (parameters, covariance)
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

/// The box with the same centre and the same spread along the axes of the tracker.
fn carried_workspace(workspace: &Workspace, frames: &Frames) -> Workspace {
    if frames.is_identity() {
        return *workspace;
    }
    let turn = frames.base.rotation;
    let mut half = [0.0; 6];
    for first in [0, 3] {
        for k in 0..3 {
            let parts = (0..3).map(|j| (turn[(k, j)] * workspace.half[first + j]).powi(2));
            half[first + k] = parts.sum::<f64>().sqrt();
        }
    }
    let centre = workspace.convention.pose(&workspace.centre);
    Workspace { centre: workspace.convention.coordinates(&frames.measured(&centre)), half, ..*workspace }
}
