//! Where the tracker and the target are.

use crate::pose::Pose;

/// Placement of the tracker and of the target: a full pose is measured as `B T(q) A`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frames {
    /// `B`: pose of the base frame in the tracker's frame.
    pub base: Pose,
    /// `A`: pose of the target's frame on the platform.
    pub target: Pose,
}

impl Frames {
    /// True if both are identities: the tracker reports in the base frame.
    pub fn is_identity(&self) -> bool {
        self.base == Pose::identity() && self.target == Pose::identity()
    }

    /// Measured pose when the platform is at `pose`: `B T A`.
    pub fn measured(&self, pose: &Pose) -> Pose {
        self.base.compose(pose).compose(&self.target)
    }

    /// The platform pose behind a measured one: `B⁻¹ T_m A⁻¹`.
    pub fn platform(&self, measured: &Pose) -> Pose {
        self.base.inverse().compose(measured).compose(&self.target.inverse())
    }
}
