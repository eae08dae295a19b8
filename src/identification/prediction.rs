//! How well the calibrated model predicts poses.

use nalgebra::{DMatrix, Matrix3x6, Matrix6};

use crate::conditions::Conditions;
use crate::mechanism::{KinematicsError, Mechanism, MotionBlock};
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

/// Predicted 1σ error of the calibrated pose over a set of poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictedError {
    /// Number of poses.
    pub poses: usize,
    /// RMS over the poses of the length of the position error, m.
    pub position_rms: f64,
    /// Largest of them, m.
    pub position_max: f64,
    /// RMS over the poses of the length of the rotation error, rad.
    pub rotation_rms: f64,
    /// Largest of them, rad.
    pub rotation_max: f64,
}

/// Predicted error at poses, as far as they have joints; the position is that of the convention's pivot. `None`
/// if none has.
pub fn predicted_errors(
    mechanism: &dyn Mechanism,
    covariance: &DMatrix<f64>,
    poses: &[Pose],
    convention: &PoseConvention,
) -> Option<PredictedError> {
    let at = Conditions::unknown();
    let (mut position, mut rotation) = (Vec::new(), Vec::new());
    for pose in poses {
        let Ok(joints) = mechanism.inverse(mechanism.values(), pose, &at) else { continue };
        let Ok(spread) = pose_covariance(mechanism, covariance, &joints, pose, &at) else { continue };
        let mut seen = Matrix3x6::zeros();
        seen.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
        seen.fixed_view_mut::<3, 3>(0, 3).copy_from(&-(pose.rotation * convention.pivot).cross_matrix());
        position.push((seen * spread * seen.transpose()).trace());
        rotation.push(spread.fixed_view::<3, 3>(3, 3).trace());
    }
    let rms = |v: &[f64]| (v.iter().sum::<f64>() / v.len() as f64).sqrt();
    let max = |v: &[f64]| v.iter().copied().fold(0.0, f64::max).sqrt();
    (!position.is_empty()).then(|| PredictedError {
        poses: position.len(),
        position_rms: rms(&position),
        position_max: max(&position),
        rotation_rms: rms(&rotation),
        rotation_max: max(&rotation),
    })
}
