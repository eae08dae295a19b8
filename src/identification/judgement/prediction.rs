//! How well the calibrated model predicts poses.

use nalgebra::{DMatrix, Matrix6};

use crate::conditions::Conditions;
use crate::mechanism::{KinematicsError, Mechanism, MotionBlock, carry_to_point, motion_of_point};
use crate::observability::{PredictedError, Spectrum};
use crate::pose::{Pose, PoseConvention};

/// Covariance (6 × 6) of the pose predicted for given joints, along small motions `(δt, δω)` of the platform:
/// `J_b Cov J_bᵀ`.
///
/// # Errors
/// [`KinematicsError`] where the motion block has no value.
pub fn pose_covariance(
    mechanism: &dyn Mechanism,
    covariance: &DMatrix<f64>,
    joints: &[f64],
    pose: &Pose,
    at: &Conditions,
) -> Result<Matrix6<f64>, KinematicsError> {
    let mut block = MotionBlock::sized_for(mechanism);
    mechanism.motion_block(mechanism.values(), joints, pose, at, &mut block)?;
    let product = &block.parameters * covariance * block.parameters.transpose();
    Ok(Matrix6::from_iterator(product.iter().copied()))
}

/// Predicted error at poses, as far as they have joints; the position is that of the convention's pivot. `None`
/// if none has.
pub fn predicted_errors(
    mechanism: &dyn Mechanism,
    covariance: &DMatrix<f64>,
    poses: &[Pose],
    convention: &PoseConvention,
) -> Option<PredictedError> {
    let blocks: Vec<DMatrix<f64>> =
        poses.iter().filter_map(|pose| motion_of_point(mechanism, pose, &convention.pivot).ok()).collect();
    (!blocks.is_empty()).then(|| PredictedError::over(&blocks, covariance))
}

/// A direction is seen if it moves some pose by at least this part of what the strongest does.
const UNSEEN: f64 = 1e-9;

/// How many directions of the parameters, in units of their tolerances times `factors`, move any of these poses.
pub(crate) fn visible_directions(
    mechanism: &dyn Mechanism,
    factors: &[f64],
    poses: &[Pose],
    convention: &PoseConvention,
) -> usize {
    let blocks: Vec<DMatrix<f64>> =
        poses.iter().filter_map(|pose| motion_of_point(mechanism, pose, &convention.pivot).ok()).collect();
    let mut rows = DMatrix::zeros(6 * blocks.len(), factors.len());
    for (k, block) in blocks.iter().enumerate() {
        rows.rows_mut(6 * k, 6).copy_from(block);
    }
    for (k, (spec, factor)) in mechanism.parameters().iter().zip(factors).enumerate() {
        rows.column_mut(k).scale_mut(factor * spec.tolerance.unwrap_or(1.0));
    }
    let values = Spectrum::of(&rows, 0, false).values;
    let limit = UNSEEN * values.iter().copied().fold(0.0, f64::max);
    values.iter().filter(|v| **v > limit).count()
}

/// The same where own parameters of the measurement say where the target sits or the tracker stands: of what an instrument sees,
/// `motion` (6 × own) being the small motion of the platform at a pose that does what each of them does. The covariance is that of
/// all parameters.
pub(crate) fn predicted_errors_as_seen(
    mechanism: &dyn Mechanism,
    covariance: &DMatrix<f64>,
    motion: impl Fn(&Pose) -> Option<DMatrix<f64>>,
    poses: &[Pose],
    convention: &PoseConvention,
) -> Option<PredictedError> {
    let n = mechanism.parameters().len();
    let block = |pose: &Pose| {
        let of_mechanism = motion_of_point(mechanism, pose, &convention.pivot).ok()?;
        let mut own = motion(pose)?;
        carry_to_point(&mut own, &(pose.rotation * convention.pivot));
        let mut block = of_mechanism.resize_horizontally(n + own.ncols(), 0.0);
        block.columns_mut(n, own.ncols()).copy_from(&own);
        Some(block)
    };
    let blocks: Vec<DMatrix<f64>> = poses.iter().filter_map(block).collect();
    (!blocks.is_empty()).then(|| PredictedError::over(&blocks, covariance))
}
