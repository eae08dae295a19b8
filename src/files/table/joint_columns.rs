//! Columns that hold the coordinate of a URDF joint instead of the length of its leg.
//!
//! Where a leg keeps the name of its joint, `leg1_slide_mm` is the coordinate `q` of that joint, and the commanded
//! length is `length + q`, or `length - q` if the coordinate counts the other way. `leg1_mm` stays the length itself.

use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::read::Reader;
use crate::files::table::column::{POSE_NAMES, target};

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
        let joint = |(leg, l): (usize, &crate::files::LegEntry)| {
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

/// Checks the names of the joints of a document; the warnings are about names that columns have already.
pub(crate) fn check_joints(r: &Reader<'_>, document: &MechanismDocument) -> Result<Vec<String>, FileError> {
    let mut warnings = Vec::new();
    for (k, leg) in document.legs.iter().enumerate() {
        let place = format!("leg {}, `joint`", k + 1);
        let Some(name) = &leg.joint else {
            if leg.joint_reversed {
                return Err(r.value(place, "is missing, but `joint_reversed` is stated; name the joint"));
            }
            continue;
        };
        if name.trim().is_empty() {
            return Err(r.value(place, "is empty; name the joint, or delete the key"));
        }
        if let Some(other) = document.legs[..k].iter().position(|l| l.joint.as_ref() == Some(name)) {
            return Err(r.value(place, format!("'{name}' is already the joint of leg {}; name another", other + 1)));
        }
        if let Some(meaning) = taken(name, document) {
            warnings.push(format!(
                "joint '{name}' has the name of other columns: in data, '{name}_{}' is {meaning} and not the coordinate \
                 of this joint",
                r.length.name
            ));
        }
    }
    Ok(warnings)
}

/// What a column of this name means already.
fn taken(name: &str, document: &MechanismDocument) -> Option<&'static str> {
    if name.strip_prefix("leg").is_some_and(|n| n.parse::<usize>().is_ok()) {
        return Some("the length of a leg");
    }
    let targets: Vec<String> = document.targets.iter().map(|t| t.name.clone()).collect();
    if target(name, &targets).is_some() {
        return Some("a measured target");
    }
    let prefix = ["sigma_", "cmd_", "temp_"].iter().any(|p| name.starts_with(p));
    (prefix || POSE_NAMES.contains(&name)).then_some("another quantity")
}
