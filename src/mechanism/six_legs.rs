//! The closure equations of six legs with static sizes: the inner loop of forward kinematics.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::six_hardpoint::{LEGS, PER_LEG};
use crate::pose::Pose;
use crate::solve::NewtonProblem;

/// Points and true lengths of six legs.
pub(super) struct SixLegs {
    pub(super) a: [Vector3<f64>; LEGS],
    pub(super) b: [Vector3<f64>; LEGS],
    pub(super) length: [f64; LEGS],
}

impl SixLegs {
    /// Residual and `J₁`.
    #[inline]
    pub(super) fn equations(&self, pose: &Pose, residual: &mut Vector6<f64>, jacobian: &mut Matrix6<f64>) {
        for i in 0..LEGS {
            let arm = pose.rotation * self.a[i];
            let l = pose.position + arm - self.b[i];
            let length = l.norm();
            let u = l / length;
            let turn = arm.cross(&u);
            residual[i] = length - self.length[i];
            for k in 0..3 {
                jacobian[(i, k)] = u[k];
                jacobian[(i, k + 3)] = turn[k];
            }
        }
    }
}

impl NewtonProblem for SixLegs {
    type Point = Pose;

    #[inline]
    fn linearize(&mut self, pose: &Pose, residual: &mut Vector6<f64>, jacobian: &mut Matrix6<f64>) {
        self.equations(pose, residual, jacobian);
    }

    #[inline]
    fn step(&self, pose: &Pose, delta: &Vector6<f64>) -> Pose {
        pose.moved(delta)
    }
}

/// The entries of `J₂` in the columns of leg `i`: `[uᵀ R, -1, -uᵀ]`.
pub(super) fn leg_row(motion: &Matrix6<f64>, i: usize, pose: &Pose) -> [f64; PER_LEG] {
    let u = Vector3::new(motion[(i, 0)], motion[(i, 1)], motion[(i, 2)]);
    let v = pose.rotation.inverse() * u;
    [v.x, v.y, v.z, -1.0, -u.x, -u.y, -u.z]
}
