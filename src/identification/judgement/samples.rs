//! What a model says of each sample; nothing is fitted.

use crate::identification::error::IdentifyError;
use crate::identification::problem::start::{own_start, poses_from_home};
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
    let poses: Vec<Pose> = poses_from_home(mechanism, data).into_iter().collect::<Result<_, _>>()?;
    Ok(each_sample_at(&poses, own, data, look))
}

/// Looks at each sample with the pose that it is given and the residual there.
pub(crate) fn each_sample_at<T>(
    poses: &[Pose],
    own: &[f64],
    data: &Dataset,
    look: impl Fn(usize, &Pose, &Rows) -> T,
) -> Vec<T> {
    let count = data.model().nuisance_parameters().len();
    let own = if own.len() == count { own.to_vec() } else { own_start(data, poses) };
    let mut rows = Rows::sized(0, count);
    let sample = |(k, pose): (usize, &Pose)| {
        let n = data.rows(k).len();
        if rows.residual.len() != n {
            rows = Rows::sized(n, count);
        }
        rows.clear();
        data.evaluate(k, pose, &own, &mut rows);
        look(k, pose, &rows)
    };
    poses.iter().enumerate().map(sample).collect()
}
