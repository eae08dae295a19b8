//! Columns that hold the coordinate of a URDF joint instead of the length of its leg.
//!
//! Where a leg keeps the name of its joint, `leg1_slide_mm` is the coordinate `q` of that joint, and the commanded
//! length is `length + q`, or `length - q` if the coordinate counts the other way. `leg1_mm` stays the length itself.

use crate::files::machine::Machine;
use crate::files::mechanism::sections::LegEntry;

/// The joint of a leg.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct JointColumn {
    pub(crate) name: String,
    /// Leg, from 0.
    pub(crate) leg: usize,
    /// Length at coordinate zero, m.
    zero: f64,
    reversed: bool,
}

impl JointColumn {
    /// The commanded length at a coordinate, m.
    pub(crate) fn length(&self, coordinate: f64) -> f64 {
        if self.reversed { self.zero - coordinate } else { self.zero + coordinate }
    }
}

impl Machine {
    /// The joints by whose names data columns may be called.
    pub(crate) fn joint_columns(&self) -> Vec<JointColumn> {
        let joint = |(leg, l): (usize, &LegEntry)| {
            let (name, length) = (l.joint.clone()?, l.length?);
            Some(JointColumn { name, leg, zero: self.length_unit.to_si(length), reversed: l.joint_reversed })
        };
        self.document.legs.iter().enumerate().filter_map(joint).collect()
    }

    /// Names of the joints: those of a URDF where the file has them, else `leg1` …
    pub fn joint_names(&self) -> Vec<String> {
        let own = |k: usize| self.document.legs.get(k).and_then(|l| l.joint.clone());
        let joints = self.mechanism.joints().iter().enumerate();
        joints.map(|(k, j)| own(k).unwrap_or_else(|| j.name.clone())).collect()
    }
}
