//! A whole calibration, simulated: measure, identify, command, and see where the platform goes.

use rand::Rng;
use thiserror::Error;

use super::{as_dataset, simulate};
use crate::conditions::Conditions;
use crate::identification::{CalibrationProblem, Identifier, IdentifyError, PriorPolicy, Task, Weights};
use crate::measurement::Noise;
use crate::mechanism::{ForwardQuery, GeometryError, KinematicsError, Mechanism};
use crate::pose::{Pose, PoseConvention, wrapped_angle};

/// How parameters are found from the measured poses.
#[derive(Clone, Copy)]
pub struct Estimator<'a> {
    /// The identifier.
    pub identifier: &'a dyn Identifier,
    /// How it weights rows.
    pub weights: Weights,
    /// Where it takes a prior from.
    pub prior: PriorPolicy,
}

/// A calibration that can be repeated with other errors of the mechanism and other noise.
#[derive(Clone, Copy)]
pub struct Trial<'a> {
    /// The mechanism as it was drawn.
    pub nominal: &'a dyn Mechanism,
    /// Poses that are commanded and measured.
    pub poses: &'a [Pose],
    /// Poses that the calibrated model is to reach.
    pub targets: &'a [Pose],
    /// How poses are stated and measured.
    pub convention: PoseConvention,
    /// Noise of a measured coordinate.
    pub noise: Noise,
    /// How parameters are found.
    pub estimator: Estimator<'a>,
}

/// Result of a trial.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TrialResult {
    /// Identified parameters in the order of the mechanism, SI.
    pub values: Vec<f64>,
    /// Where the platform went when the calibrated model commanded it to the targets.
    pub errors: TargetErrors,
}

/// Distances from the targets to where the platform went.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct TargetErrors {
    /// Length of each position error, eq. (41), m.
    pub positions: Vec<f64>,
    /// Length of each vector of angle errors, eq. (42), rad.
    pub rotations: Vec<f64>,
}

/// Why a simulated calibration failed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TrialError {
    /// A pose cannot be commanded or reached.
    #[error("pose {index}: {cause}")]
    Pose {
        /// 0-based index of the pose.
        index: usize,
        /// Why.
        cause: KinematicsError,
    },
    /// A target cannot be commanded or reached.
    #[error("target {index}: {cause}")]
    Target {
        /// 0-based index of the target.
        index: usize,
        /// Why.
        cause: KinematicsError,
    },
    /// The identification failed.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// The identified parameters make no mechanism.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
}

impl Trial<'_> {
    /// Calibrates a mechanism whose true parameters are those of `truth`, once.
    ///
    /// # Errors
    /// [`TrialError`].
    pub fn run<R: Rng + ?Sized>(&self, truth: &dyn Mechanism, rng: &mut R) -> Result<TrialResult, TrialError> {
        let samples = simulate(self.nominal, truth, self.poses, &self.convention, &self.noise, rng)
            .map_err(|(index, cause)| TrialError::Pose { index, cause })?;
        let measured = as_dataset(&samples, &self.convention, &self.noise);
        let Estimator { identifier, weights, prior } = self.estimator;
        let mut problem = CalibrationProblem::new(&Task { weights, prior, ..Task::new(self.nominal, &measured) })?;
        let fit = identifier.estimate(&mut problem)?;
        let values = fit.values.as_slice()[..problem.mechanism_parameters()].to_vec();
        let model = self.nominal.with_values(&values, self.nominal.home())?;
        let errors = target_errors(model.as_ref(), truth, self.targets, &self.convention)?;
        Ok(TrialResult { values, errors })
    }
}

/// Where `truth` goes when `model` commands it to the targets.
///
/// # Errors
/// [`TrialError::Target`].
pub fn target_errors(
    model: &dyn Mechanism,
    truth: &dyn Mechanism,
    targets: &[Pose],
    convention: &PoseConvention,
) -> Result<TargetErrors, TrialError> {
    let at = Conditions::unknown();
    let mut errors = TargetErrors::default();
    let about = |index| move |cause| TrialError::Target { index, cause };
    let command = |(index, target)| model.inverse(model.values(), target, &at).map_err(about(index));
    let commands: Vec<Vec<f64>> = targets.iter().enumerate().map(command).collect::<Result<_, _>>()?;
    let queries: Vec<ForwardQuery<'_>> =
        commands.iter().zip(targets).map(|(joints, target)| ForwardQuery::new(joints, &at, *target)).collect();
    let all_reached = truth.forward_batch(truth.values(), &queries);
    for (index, (target, reached)) in targets.iter().zip(all_reached).enumerate() {
        let reached = reached.map_err(about(index))?;
        let (wanted, went) = (convention.coordinates(target), convention.coordinates(&reached));
        let length = |range: std::ops::Range<usize>, difference: fn(f64) -> f64| {
            range.map(|k| difference(went[k] - wanted[k]).powi(2)).sum::<f64>().sqrt()
        };
        errors.positions.push(length(0..3, |d| d));
        errors.rotations.push(length(3..6, wrapped_angle));
    }
    Ok(errors)
}

impl TargetErrors {
    /// The paper's integrated error, eqs. (43) and (44): root mean square over the targets of the position error in
    /// millimetres plus the attitude error in degrees. (The paper calls the sum dimensionless; it depends on these
    /// units.)
    pub fn integrated(&self) -> f64 {
        let sum = |(p, r): (&f64, &f64)| (1e3 * p + r.to_degrees()).powi(2);
        let squares: f64 = self.positions.iter().zip(&self.rotations).map(sum).sum();
        (squares / self.positions.len() as f64).sqrt()
    }
}
