//! What a model says of each sample; nothing is fitted.

use crate::identification::error::IdentifyError;
use crate::identification::problem::calibration_problem::{own_start, pose_from_home};
use crate::measurement::{Dataset, Rows};
use crate::mechanism::Mechanism;
use crate::pose::Pose;

/// Looks at each sample with its predicted pose and its residual `ŷ - y`.
pub(crate) fn each_sample<T>(
    mechanism: &dyn Mechanism,
    own: &[f64],
    data: &Dataset,
    look: impl Fn(usize, &Pose, &Rows) -> T,
) -> Result<Vec<T>, IdentifyError> {
    let count = data.model().nuisance_parameters().len();
    let poses: Vec<Pose> = (0..data.len()).map(|k| pose_from_home(mechanism, data, k)).collect::<Result<_, _>>()?;
    let own = if own.len() == count { own.to_vec() } else { own_start(data, &poses) };
    let sample = |(k, pose): (usize, &Pose)| {
        let mut rows = Rows::sized(data.rows(k).len(), count);
        data.evaluate(k, pose, &own, &mut rows);
        look(k, pose, &rows)
    };
    Ok(poses.iter().enumerate().map(sample).collect())
}
