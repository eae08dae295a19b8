//! How well the calibrated model predicts poses.

use nalgebra::{DMatrix, Matrix6};

use crate::conditions::Conditions;
use crate::mechanism::{KinematicsError, Mechanism, MotionBlock, motion_of_point};
use crate::observability::PredictedError;
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
