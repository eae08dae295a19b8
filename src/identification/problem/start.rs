//! Where an identification starts: the poses of the samples for the mechanism as it is given.

use crate::identification::error::IdentifyError;
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

/// Poses from home or, where there is none, from the reading in the frames of the data.
pub(crate) fn or_from_readings(
    from_home: Vec<Result<Pose, IdentifyError>>,
    mechanism: &dyn Mechanism,
    data: &Dataset,
) -> Result<Vec<Pose>, IdentifyError> {
    let solve = |(k, pose): (usize, Result<Pose, IdentifyError>)| {
        pose.or_else(|error| {
            let (sample, (model, index)) = (data.sample(k), data.reading(k));
            let seed = model.rigid_pose(index).map(|p| data.frames.platform(&p)).ok_or_else(|| error.clone())?;
            mechanism.forward(mechanism.values(), &sample.joints, &sample.conditions, &seed).map_err(|_| error)
        })
    };
    from_home.into_iter().enumerate().map(solve).collect()
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
