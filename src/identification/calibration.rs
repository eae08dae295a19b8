//! The whole job: frames, prior, identification, judgement.

use nalgebra::{DMatrix, Vector3};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use super::errors_of_model::{ErrorSummary, evaluate};
use super::held_out::held_out;
use super::prediction::{PredictedError, predicted_errors};
use super::weak_directions::{DataSpectrum, WeakDirection, weak_directions};
use super::{
    Estimate, HeldOut, Holdout, Identification, Identifier, IdentifyError, Plausibility, PriorPolicy, Registration,
    Task, Weights, plausibility, register,
};
use crate::measurement::{Dataset, Frames};
use crate::mechanism::{Body, Mechanism, Workspace};
use crate::pose::{Pose, PoseConvention};
use crate::units::shortened;

/// What is asked of a calibration.
#[derive(Clone, Debug)]
pub struct CalibrationOptions {
    /// Where priors come from.
    pub prior: PriorPolicy,
    /// How rows are weighted.
    pub weights: Weights,
    /// Which rows are held out to measure the errors.
    pub holdout: Holdout,
    /// Seed of the folds and of the poses at which errors are predicted.
    pub seed: u64,
}

impl Default for CalibrationOptions {
    fn default() -> Self {
        Self { prior: PriorPolicy::Auto, weights: Weights::Noise, holdout: Holdout::Folds(5), seed: 0 }
    }
}

/// May the result be used?
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// True if nothing speaks against it.
    pub trusted: bool,
    /// What speaks against it, one sentence each.
    pub reasons: Vec<String>,
    /// What the user should know although it does not forbid the use.
    pub warnings: Vec<String>,
}

/// A calibrated mechanism and how far to trust it.
#[derive(Debug)]
pub struct Calibration {
    /// The calibrated mechanism, in the frames of the measurement.
    pub mechanism: Box<dyn Mechanism>,
    /// Its parameters, then those of the measurement, in the frames of the measurement.
    pub parameters: Vec<Estimate>,
    /// Covariance of the mechanism's parameters, in the same frames.
    pub covariance: DMatrix<f64>,
    /// What the identifier found, in the frames of the nominal mechanism.
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
    pub verdict: Verdict,
}

/// A misfit this unlikely is not chance.
const MISFIT: f64 = 1e-6;
const PREDICTED_POSES: usize = 200;

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
    let mut registration = register(mechanism, data)?;
    if !data.model().has_target_frame() {
        registration.frames.target = Pose::identity();
    }
    let frames = registration.frames;
    let aligned = data.with_frames(frames);
    let task = Task { prior: options.prior, weights: options.weights, ..Task::new(mechanism, &aligned) };
    let (found, converged) = match identifier.identify(&task) {
        Ok(found) => (found, true),
        Err(IdentifyError::NotConverged { last, .. }) => (*last, false),
        Err(error) => return Err(error),
    };
    let (parameters, covariance) = carry(mechanism, &found, &frames);
    let values: Vec<f64> = parameters[..found.mechanism_parameters].iter().map(|p| p.value).collect();
    let calibrated = mechanism.with_values(&values, frames.measured(&mechanism.home()))?;
    let own = found.own_values();
    let held = match &options.holdout {
        Holdout::Data(other) => {
            let errors = evaluate(calibrated.as_ref(), &own, other).map_err(|e| IdentifyError::HeldOut(Box::new(e)))?;
            Some(HeldOut { rms: errors.rms(), samples: errors.samples.len() })
        }
        holdout => held_out(identifier, &task, holdout, options.seed)?,
    };
    let spectrum = DataSpectrum::at_start(&task, found.noise_scale)?;
    let result = Calibration {
        before: evaluate(mechanism, &[], data)?.rms(),
        after: evaluate(calibrated.as_ref(), &own, data)?.rms(),
        held_out: held,
        predicted: predict(mechanism, &found, workspace, &frames, options.seed)?,
        weak: weak_directions(mechanism, &spectrum),
        plausibility: plausibility(mechanism, &values),
        workspace: workspace.map(|w| carried_workspace(w, &frames)),
        verdict: judge(mechanism, data, &found, converged),
        mechanism: calibrated,
        parameters,
        covariance,
        identification: found,
        converged,
        registration,
    };
    Ok(with_warnings(result, data, &options.holdout))
}

fn judge(mechanism: &dyn Mechanism, data: &Dataset, found: &Identification, converged: bool) -> Verdict {
    let mut reasons = Vec::new();
    if !converged {
        reasons.push("the iteration did not converge".into());
    }
    let unknowns = found.parameters.len();
    if found.rank < unknowns {
        let missing = unknowns - found.rank;
        reasons.push(format!(
            "the poses leave {missing} of {unknowns} parameter directions undetermined and there is no prior; \
             measure other poses or state a [tolerance]"
        ));
    }
    if let Some(p) = found.misfit.p_value().filter(|p| *p < MISFIT) {
        let scale = found.misfit.scale().unwrap_or(f64::NAN);
        reasons.push(format!(
            "the residuals are {scale:.3} times the stated noise, which chance does not explain (p = {p:.0e}); \
             the model misses something, the file is misread, or the noise is understated"
        ));
    }
    let mut warnings = Vec::new();
    if found.misfit.degrees_of_freedom == 0 {
        warnings.push("every row is used up by parameters, so the fit cannot be checked against the noise".into());
    }
    let outside: Vec<String> =
        data.iter().filter(|s| !mechanism.within_strokes(&s.joints)).map(|s| s.row.to_string()).collect();
    if !outside.is_empty() {
        warnings.push(format!("joints outside their stroke in data row {}", shortened(&outside)));
    }
    if !found.outliers.is_empty() {
        let rows: Vec<String> = found.outliers.iter().map(|k| data.sample(*k).row.to_string()).collect();
        warnings.push(format!("gross errors in data row {}; they were given no or little weight", shortened(&rows)));
    }
    Verdict { trusted: reasons.is_empty(), reasons, warnings }
}

fn with_warnings(mut result: Calibration, data: &Dataset, holdout: &Holdout) -> Calibration {
    let warnings = &mut result.verdict.warnings;
    if result.held_out.is_none() && !matches!(holdout, Holdout::None) {
        warnings.push("no errors on held-out rows: too few would be left to fit".into());
    }
    if result.registration.applied {
        warnings.push(
            "the data are in a frame of their own; the calibrated model is in the frames of the measurement \
             (see frames)"
                .into(),
        );
    }
    let implausible = &result.plausibility.implausible;
    if let Some(worst) = implausible.iter().max_by(|a, b| a.deviation.abs().total_cmp(&b.deviation.abs())) {
        warnings.push(format!(
            "{} of the parameters deviate by more than 4 tolerances, most of all {} ({:+.3} mm); \
             a small residual with such values means that another cause hides in them",
            implausible.len(),
            worst.name,
            1e3 * worst.deviation
        ));
    }
    if !data.noise.known && result.identification.misfit.degrees_of_freedom > 0 {
        let scale = result.identification.noise_scale * data.noise.position;
        warnings.push(format!(
            "no noise is stated; it was estimated from the residuals as {:.3} um per position coordinate",
            1e6 * scale
        ));
    }
    result
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
    for (k, p) in parameters.iter_mut().take(n).enumerate() {
        p.sigma = p.sigma.map(|_| covariance[(k, k)].max(0.0).sqrt());
    }
    (parameters, covariance)
}

fn predict(
    mechanism: &dyn Mechanism,
    found: &Identification,
    workspace: Option<&Workspace>,
    frames: &Frames,
    seed: u64,
) -> Result<Option<PredictedError>, IdentifyError> {
    if found.rank < found.parameters.len() {
        return Ok(None);
    }
    let aligned = mechanism.with_values(&found.mechanism_values(), mechanism.home())?;
    let (poses, convention) = match workspace {
        Some(w) => {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            ((0..PREDICTED_POSES).map(|_| w.random(&mut rng)).collect(), w.convention)
        }
        None => (found.poses.clone(), PoseConvention::default()),
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
