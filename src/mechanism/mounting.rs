//! A mechanism as an instrument sees it.

use nalgebra::{Matrix3, Matrix6};

use crate::pose::Pose;

/// Where the base stands in the frame of the measurement, and the target on the platform.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Mounting {
    pub(crate) base: Pose,
    pub(crate) target: Pose,
}

impl Mounting {
    /// The mechanism's own pose of a measured one: `B⁻¹ T A⁻¹`.
    pub(crate) fn inner(&self, pose: &Pose) -> Pose {
        self.base.inverse().compose(pose).compose(&self.target.inverse())
    }

    /// The measured pose of one of the mechanism's own: `B T A`.
    pub(crate) fn outer(&self, pose: &Pose) -> Pose {
        self.base.compose(pose).compose(&self.target)
    }

    /// This mounting within another frame.
    pub(crate) fn within(&self, base: &Pose, target: &Pose) -> Self {
        Self { base: base.compose(&self.base), target: self.target.compose(target) }
    }

    /// Small motion of the platform in its own frames per small motion as it is measured.
    pub(crate) fn inner_motion(&self, pose: &Pose, inner: &Pose) -> Matrix6<f64> {
        let back: Matrix3<f64> = *self.base.rotation.inverse().matrix();
        let arm = self.base.place(&inner.position) - pose.position;
        let mut m = Matrix6::zeros();
        m.fixed_view_mut::<3, 3>(0, 0).copy_from(&back);
        m.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-back * arm.cross_matrix()));
        m.fixed_view_mut::<3, 3>(3, 3).copy_from(&back);
        m
    }
}
