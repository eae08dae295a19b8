//! Where an identification starts: the poses of the samples for the mechanism as it is given.

use nalgebra::Vector6;

use crate::identification::error::IdentifyError;
use crate::identification::problem::belief::Conventions;
use crate::identification::problem::closure_fit::{ClosureFit, ClosureRow, Look};
use crate::identification::problem::prior::Prior;
use crate::measurement::Dataset;
use crate::mechanism::{ForwardQuery, KinematicsError, Mechanism};
use crate::pose::Pose;

/// The poses of all samples at the mechanism's values, from home.
pub(crate) fn poses_from_home(mechanism: &dyn Mechanism, data: &Dataset) -> Vec<Result<Pose, IdentifyError>> {
    let home = mechanism.home();
    let queries: Vec<ForwardQuery<'_>> =
        data.iter().map(|s| ForwardQuery::new(&s.joints, &s.conditions, home)).collect();
    let named = |(k, pose): (usize, Result<Pose, KinematicsError>)| pose.map_err(|cause| sample_error(data, k, cause));
    mechanism.forward_batch(mechanism.values(), &queries).into_iter().enumerate().map(named).collect()
}

/// Where an identification begins.
pub(crate) struct Start {
    /// Pose of each sample for the mechanism as it is given; the measured one where it does not reach the sample.
    pub(crate) poses: Vec<Pose>,
    /// Where the closure fits best, if the mechanism as it is given does not reach all samples.
    pub(crate) near: Option<Near>,
}

/// Parameters of a mechanism near the given ones that reach all samples.
pub(crate) struct Near {
    pub(crate) values: Vec<f64>,
    /// The poses of the samples.
    pub(crate) poses: Vec<Pose>,
}

/// Fewest measured poses that say anything of a mechanism that does not reach a sample.
const FEWEST: usize = 3;
/// How far the parameters may be from the drawing for a start, in tolerances.
const TOLERANCES: f64 = 10.0;

/// Where an identification begins: with the mechanism as given if it reaches all samples, from home or from the reading, and
/// otherwise where the closure fits the measured poses best.
///
/// # Errors
/// [`IdentifyError::Sample`] of the first sample that is not reached either way.
pub(crate) fn start(
    from_home: Vec<Result<Pose, IdentifyError>>,
    mechanism: &dyn Mechanism,
    data: &Dataset,
    conventions: Conventions,
) -> Result<Start, IdentifyError> {
    let from_reading = |(k, pose): (usize, Result<Pose, IdentifyError>)| {
        pose.or_else(|error| {
            let seed = from_reading(data, k).ok_or_else(|| error.clone())?;
            forward(mechanism, mechanism.values(), data, k, &seed).map_err(|_| error)
        })
    };
    let solved: Vec<Result<Pose, IdentifyError>> = from_home.into_iter().enumerate().map(from_reading).collect();
    let near =
        solved.iter().any(Result::is_err).then(|| closure_start(mechanism, data, conventions, &solved)).flatten();
    let pose = |(k, pose): (usize, Result<Pose, IdentifyError>)| match &near {
        Some(near) => Ok(pose.unwrap_or(near.poses[k])),
        None => pose,
    };
    let poses = solved.into_iter().enumerate().map(pose).collect::<Result<_, _>>()?;
    Ok(Start { poses, near })
}

fn forward(
    mechanism: &dyn Mechanism,
    c: &[f64],
    data: &Dataset,
    k: usize,
    seed: &Pose,
) -> Result<Pose, KinematicsError> {
    let sample = data.sample(k);
    mechanism.forward(c, &sample.joints, &sample.conditions, seed)
}

/// The pose of the platform as the reading has it, in the frames of the data.
fn from_reading(data: &Dataset, k: usize) -> Option<Pose> {
    let (model, index) = data.reading(k);
    model.rigid_pose(index).map(|p| data.frames.platform(&p))
}

/// The parameters for which the closure fits the measured poses best, if they reach all samples; `solved` are the poses of the
/// mechanism as it is given.
pub(crate) fn closure_start(
    mechanism: &dyn Mechanism,
    data: &Dataset,
    conventions: Conventions,
    solved: &[Result<Pose, IdentifyError>],
) -> Option<Near> {
    let read = |k: usize| {
        let (model, index) = data.reading(k);
        let sample = data.sample(k);
        Some(ClosureRow { joints: &sample.joints, pose: model.rigid_pose(index)?, at: &sample.conditions })
    };
    let rows: Vec<ClosureRow<'_>> = (0..data.len()).filter_map(read).collect();
    if rows.len() < FEWEST {
        return None;
    }
    let (p, r) = (1.0 / data.noise.position, 1.0 / data.noise.rotation);
    let prior = Prior::wide(mechanism, TOLERANCES, conventions);
    let fit = ClosureFit::new(mechanism, &prior, Vector6::new(p, p, p, r, r, r));
    let values = fit.fit(&rows, &data.frames, Look::Start)?.values;
    let reached = |(k, pose): (usize, &Result<Pose, IdentifyError>)| {
        let seed = from_reading(data, k).or(pose.as_ref().ok().copied()).unwrap_or(mechanism.home());
        forward(mechanism, &values, data, k, &seed).ok()
    };
    let poses = solved.iter().enumerate().map(reached).collect::<Option<_>>()?;
    Some(Near { values, poses })
}

/// Start values of the measurement's own parameters, for the poses of the samples of `data`.
pub(crate) fn own_start(data: &Dataset, poses: &[Pose]) -> Vec<f64> {
    let mut all = vec![None; data.model().samples()];
    for (k, pose) in poses.iter().enumerate() {
        all[data.reading(k).1] = Some(*pose);
    }
    data.model().start(&all, &data.frames)
}

/// A failure of the kinematics at the `k`-th sample.
pub(crate) fn sample_error(data: &Dataset, k: usize, cause: KinematicsError) -> IdentifyError {
    let sample = data.sample(k);
    let label = sample.id.as_ref().map_or(String::new(), |id| format!(" ({id})"));
    IdentifyError::Sample { row: sample.row, label, cause }
}
