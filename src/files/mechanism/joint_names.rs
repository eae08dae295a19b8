//! Names of URDF joints that a mechanism file keeps for its legs.

use crate::conditions::ConditionTable;
use crate::files::error::FileError;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::reader::Reader;
use crate::files::table::column::{POSE_NAMES, target};

/// Checks the names of the joints of a document; the warnings are about names that columns have already.
pub(crate) fn check_joints(
    r: &Reader<'_>,
    document: &MechanismDocument,
    kinds: &ConditionTable,
) -> Result<Vec<String>, FileError> {
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
        if let Some(meaning) = taken(name, document, kinds) {
            warnings.push(format!(
                "joint '{name}' has the name of other columns: in data, '{name}_{}' is {meaning} and not the coordinate \
                 of this joint",
                r.units.length.name
            ));
        }
    }
    Ok(warnings)
}

/// What a column of this name means already.
fn taken(name: &str, document: &MechanismDocument, kinds: &ConditionTable) -> Option<&'static str> {
    if name.strip_prefix("leg").is_some_and(|n| n.parse::<usize>().is_ok()) {
        return Some("the length of a leg");
    }
    let targets: Vec<String> = document.targets.iter().map(|t| t.name.clone()).collect();
    if target(name, &targets).is_some() {
        return Some("a measured target");
    }
    let prefix = ["sigma_", "cmd_"].iter().any(|p| name.starts_with(p));
    let condition = kinds.of(name).is_some_and(|kind| kind.needs_unit && kind.is_recorded());
    (prefix || condition || POSE_NAMES.contains(&name)).then_some("another quantity")
}
