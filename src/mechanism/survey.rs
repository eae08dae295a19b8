//! Ranges of joints and conditioning over a workspace.

use super::{Mechanism, Workspace, condition, consistent};
use crate::conditions::Conditions;
use crate::pose::Pose;

/// Extremes over a set of poses.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Survey {
    /// Poses looked at.
    pub poses: usize,
    /// Poses that need a joint outside its stroke.
    pub outside_stroke: usize,
    /// Poses that have no joints or where forward kinematics does not lead back.
    pub unreachable: usize,
    /// Smallest and largest coordinate of each joint.
    pub joint_range: Vec<[f64; 2]>,
    /// Largest condition of `J₁`, angles scaled by the platform radius.
    pub worst_condition: f64,
}

impl Survey {
    /// Looks at the centre and the corners of a workspace and at `further` poses.
    pub fn of(mechanism: &dyn Mechanism, workspace: &Workspace, further: &[Pose]) -> Self {
        let at = Conditions::unknown();
        let c = mechanism.values();
        let mut survey = Self {
            poses: 0,
            outside_stroke: 0,
            unreachable: 0,
            joint_range: vec![[f64::INFINITY, f64::NEG_INFINITY]; mechanism.joints().len()],
            worst_condition: 0.0,
        };
        let centre = workspace.pose(&[0.0; 6]);
        for pose in std::iter::once(&centre).chain(&workspace.corners()).chain(further) {
            survey.poses += 1;
            let Ok((pose, joints)) = consistent(mechanism, c, pose, &at) else {
                survey.unreachable += 1;
                continue;
            };
            let back = mechanism.forward(c, &joints, &at, &mechanism.home());
            if !back.is_ok_and(|p| p.motion_to(&pose).amax() < 1e-6) {
                survey.unreachable += 1;
            }
            for (range, value) in survey.joint_range.iter_mut().zip(&joints) {
                *range = [range[0].min(*value), range[1].max(*value)];
            }
            survey.outside_stroke += usize::from(!mechanism.within_strokes(&joints));
            survey.worst_condition = survey.worst_condition.max(condition(mechanism, c, &joints, &pose, &at));
        }
        survey
    }
}
