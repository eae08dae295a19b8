//! Meaning of a table column, from its name.

use crate::conditions::{ConditionTable, Role};
use crate::files::table::joint_columns::JointColumn;
use crate::mechanism::{JointSpec, Mechanism};
use crate::units::{Dimension, Unit};

/// Meaning of a column.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Meaning {
    /// Label of the row.
    Id,
    /// Coordinate of a joint.
    Joint(usize),
    /// Coordinate of the measured pose.
    Pose(usize),
    /// Component w x y z of the measured rotation.
    Quaternion(usize),
    /// 1σ of a coordinate of the measured pose.
    Sigma(usize),
    /// What a kind of reading other than the pose measures.
    Reading(ReadingColumn),
    /// Coordinate of the commanded pose.
    Commanded(usize),
    /// Clock time.
    Clock,
    /// What `compensate` says of the command of the row; readers pass it over.
    Check,
    /// Anything else that is a number, by name without unit.
    Covariate(String),
}

/// A column of a kind of reading.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ReadingColumn {
    /// The name of the kind.
    pub(crate) kind: &'static str,
    /// What is measured: the name of a target.
    pub(crate) quantity: String,
    /// Which coordinate of it.
    pub(crate) axis: usize,
    /// True for its 1σ.
    pub(crate) sigma: bool,
}

/// What names of columns mean to the kinds of reading, with the dimension of their numbers.
pub(crate) type ReadingNames<'a> = &'a dyn Fn(&str) -> Option<(ReadingColumn, Dimension)>;

/// A column with the unit that its name states.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) meaning: Meaning,
    pub(crate) unit: Option<Unit>,
    /// Set if the column holds the coordinate of a URDF joint instead of a length.
    pub(crate) joint: Option<JointColumn>,
}

/// The components of a direction of gravity.
pub(crate) const GRAVITY_NAMES: [&str; 3] = ["gravity_x", "gravity_y", "gravity_z"];
/// The angle from the vertical, which stands for the elevation.
pub(crate) const ZENITH_DISTANCE: &str = "zenith_distance";

impl Column {
    /// The name of a covariate that has no meaning here: nothing but a search for causes looks at it.
    pub(crate) fn foreign(&self, kinds: &ConditionTable) -> Option<&str> {
        let Meaning::Covariate(name) = &self.meaning else { return None };
        let known = kinds.of(name).is_some() || name == ZENITH_DISTANCE || GRAVITY_NAMES.contains(&name.as_str());
        (!known).then_some(name)
    }

    /// True for such a covariate.
    fn is_foreign(&self, kinds: &ConditionTable) -> bool {
        self.foreign(kinds).is_some()
    }
}

pub(crate) const POSE_NAMES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// Dimension of a pose coordinate.
pub(crate) fn pose_dimension(k: usize) -> Dimension {
    if k < 3 { Dimension::Length } else { Dimension::Angle }
}

/// The column that a name stands for.
///
/// # Errors
/// The problem with the name, and its remedy.
pub(crate) fn column(
    name: &str,
    header: &[String],
    mechanism: &dyn Mechanism,
    readings: ReadingNames<'_>,
    joints: &[JointColumn],
    kinds: &ConditionTable,
) -> Result<Column, String> {
    let (base, unit) = match name.rsplit_once('_') {
        Some((base, suffix)) => match Unit::named(suffix) {
            Some(unit) => (base, Some(unit)),
            None => (name, None),
        },
        None => (name, None),
    };
    let pose = |text: &str| POSE_NAMES.iter().position(|n| *n == text);
    let with = |meaning: Meaning, dimension: Dimension| match unit {
        Some(unit) if unit.dimension == dimension => {
            Ok(Column { name: name.into(), meaning, unit: Some(unit), joint: None })
        }
        Some(unit) => Err(format!("'{}' is not a unit for it; use one of {}", unit.name, dimension.choices())),
        None => Err(missing_unit(name, base, dimension, kinds)),
    };
    if let Some(meaning) = whole_name(name, kinds) {
        return Ok(Column { name: name.into(), meaning, unit: None, joint: None });
    }
    // A unit that is none of ours: `x_furlong` is meant as a pose column, and must not become a covariate. Beside
    // `leg1_mm`, though, `leg1_load` is one.
    let stem = name.rsplit_once('_').map_or(name, |(stem, _)| stem);
    let proper = |h: &String| h.rsplit_once('_').is_some_and(|(s, unit)| s == stem && Unit::named(unit).is_some());
    let meant = if header.iter().any(proper) { base } else { stem };
    for candidate in [base, meant] {
        if let Some(k) = joint(candidate, mechanism.joints()) {
            return with(Meaning::Joint(k), mechanism.joints()[k].dimension);
        }
        if let Some(k) = pose(candidate) {
            return with(Meaning::Pose(k), pose_dimension(k));
        }
        if let Some(k) = candidate.strip_prefix("sigma_").and_then(pose) {
            return with(Meaning::Sigma(k), pose_dimension(k));
        }
        if let Some(k) = candidate.strip_prefix("cmd_").and_then(pose) {
            return with(Meaning::Commanded(k), pose_dimension(k));
        }
        if let Some((reading, dimension)) = readings(candidate) {
            return with(Meaning::Reading(reading), dimension);
        }
        if let Some(kind) = kinds.of(candidate).filter(|kind| kind.is_recorded() && kind.dimension != Dimension::None) {
            check_leg_of(candidate, mechanism, kinds)?;
            // What needs no unit may state none, but not a wrong one.
            if kind.needs_unit || unit.is_some() || candidate != base {
                let or = if kind.needs_unit { "" } else { "; or rename the column if it is something else" };
                return with(Meaning::Covariate(candidate.into()), kind.dimension).map_err(|problem| problem + or);
            }
        }
        if let Some(joint) = joints.iter().find(|j| j.name == candidate) {
            if unit.is_none() {
                let choices = Dimension::Length.choices();
                return Err(format!("the name must end in a unit ({choices}), such as '{}_mm'", joint.name));
            }
            let column = with(Meaning::Joint(joint.leg), Dimension::Length)?;
            return Ok(Column { joint: Some(joint.clone()), ..column });
        }
    }
    check_leg(base, mechanism.joints())?;
    if base.contains(|c: char| c.is_ascii_uppercase()) {
        // Capitals would turn a measured coordinate into a covariate without a word.
        let small = format!("{}{}", base.to_lowercase(), &name[base.len()..]);
        match column(&small, &[], mechanism, readings, joints, kinds) {
            Ok(known) if !known.is_foreign(kinds) => {
                return Err(format!("names are lower case; did you mean '{small}'?"));
            }
            Ok(_) => {}
            Err(problem) => return Err(format!("names are lower case; written so, {problem}")),
        }
    }
    Ok(Column { name: name.into(), meaning: Meaning::Covariate(base.into()), unit, joint: None })
}

/// What a name means that ends in no unit.
fn whole_name(name: &str, kinds: &ConditionTable) -> Option<Meaning> {
    let clock = name.strip_suffix("_utc").and_then(|n| kinds.of(n)).is_some_and(|kind| kind.role == Role::Clock);
    match name {
        "id" => Some(Meaning::Id),
        "check" => Some(Meaning::Check),
        _ if clock => Some(Meaning::Clock),
        _ => ["qw", "qx", "qy", "qz"].iter().position(|q| *q == name).map(Meaning::Quaternion),
    }
}

/// Refuses the name of a leg that the mechanism does not have.
fn check_leg(base: &str, joints: &[JointSpec]) -> Result<(), String> {
    if leg_number(base).is_none() {
        return Ok(());
    }
    if joints.iter().all(|j| leg_number(&j.name).is_none()) {
        let joints = joints.iter().map(|j| j.name.as_str()).collect::<Vec<_>>().join(", ");
        return Err(format!("the mechanism has no legs; its joints are {joints}; rename or delete the column"));
    }
    Err(format!("the mechanism has legs 1 to {}; correct the number or delete the column", joints.len()))
}

/// Refuses the condition of a leg that the mechanism does not have.
fn check_leg_of(covariate: &str, mechanism: &dyn Mechanism, kinds: &ConditionTable) -> Result<(), String> {
    let of_parameters = mechanism.parameters().iter().filter_map(|p| p.role.leg()).max().map_or(0, |leg| leg + 1);
    let legs = mechanism.joints().len().max(of_parameters);
    match kinds.leg_of(covariate) {
        Some(leg) if leg >= legs => {
            Err(format!("the mechanism has legs 1 to {legs}; correct the number or delete the column"))
        }
        _ => Ok(()),
    }
}

fn missing_unit(name: &str, base: &str, dimension: Dimension, kinds: &ConditionTable) -> String {
    let choices = dimension.choices();
    let (first, _) = dimension.in_tables();
    // What follows the last underscore is a unit that is none of ours, unless it belongs to the name.
    let whole = |stem: &str| matches!(stem, "cmd" | "sigma") || kinds.of(name).is_some() && kinds.of(stem).is_none();
    let stem = match name.rsplit_once('_') {
        Some((stem, _)) if name == base && !whole(stem) => stem,
        _ if name == base => name,
        _ => base,
    };
    format!("the name must end in a unit ({choices}), such as '{stem}_{first}'")
}

fn joint(name: &str, joints: &[JointSpec]) -> Option<usize> {
    joints.iter().position(|j| j.name == name)
}

fn leg_number(name: &str) -> Option<usize> {
    name.strip_prefix("leg")?.parse().ok()
}

/// Target and axis of `p1x`, or of the name of a target of the mechanism file with an axis.
pub(crate) fn target(name: &str, targets: &[String]) -> Option<(String, usize)> {
    let axis = ["x", "y", "z"].iter().position(|a| name.ends_with(a))?;
    let stem = &name[..name.len() - 1];
    let numbered = stem.strip_prefix('p').is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()));
    (numbered || targets.iter().any(|t| t == stem)).then(|| (stem.to_owned(), axis))
}
