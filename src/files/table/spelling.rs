//! Coordinates of the pose under names that other programs give them.
//!
//! A column `roll_deg` or `X` would be taken for a condition, and the measured attitude or position would be dropped without
//! a word. It is refused where the coordinate that it may mean has no column.

use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::table::column::{Meaning, POSE_NAMES, pose_dimension};
use crate::files::table::text_table::{Table, without_brackets};
use crate::units::{Dimension, Unit, shortened};

/// Words beside the name of a coordinate that say nothing of which it is.
const FILLERS: [&str; 24] = [
    "act",
    "actual",
    "effector",
    "ee",
    "fb",
    "fbk",
    "feedback",
    "flange",
    "is",
    "laser",
    "meas",
    "measured",
    "measurement",
    "mirror",
    "observed",
    "platform",
    "pose",
    "read",
    "reading",
    "real",
    "tcp",
    "tool",
    "top",
    "tracker",
];
/// Words that with an axis name a position; those of [`PLAIN`] do so without a unit too.
const POSITIONS: [&str; 12] =
    ["", "coord", "coordinate", "d", "disp", "displacement", "p", "pos", "position", "t", "trans", "translation"];
/// The same for an angle.
const TURNS: [&str; 19] = [
    "a",
    "ang",
    "angle",
    "att",
    "attitude",
    "eul",
    "euler",
    "o",
    "ori",
    "orientation",
    "r",
    "rot",
    "rotation",
    "th",
    "theta",
    "tilt",
    "turn",
    "w",
    "ω",
];
/// Words that mean a coordinate even without a unit.
const PLAIN: [&str; 13] =
    ["", "eul", "euler", "ori", "orientation", "pos", "position", "r", "rot", "rotation", "t", "trans", "translation"];
/// Names of angles without an axis, and the coordinates that they may mean; the axes of a, b, c and of Greek letters differ
/// from one maker to another.
const ANGLES: [(&str, &[usize]); 22] = [
    ("roll", &[3]),
    ("pitch", &[4]),
    ("yaw", &[5]),
    ("heading", &[5]),
    ("alpha", &[3]),
    ("beta", &[4]),
    ("gamma", &[5]),
    ("α", &[3]),
    ("β", &[4]),
    ("γ", &[5]),
    ("u", &[3]),
    ("v", &[4]),
    ("w", &[5]),
    ("a", &[3, 5]),
    ("b", &[4]),
    ("c", &[5, 3]),
    ("phi", &[3, 5]),
    ("theta", &[4]),
    ("psi", &[5, 3]),
    ("tip", &[3, 4]),
    ("tilt", &[4, 3]),
    ("twist", &[5]),
];
/// Names of angles that mean one even without a unit.
const PLAIN_ANGLES: [&str; 3] = ["roll", "pitch", "yaw"];
/// Words before the component of a quaternion.
const QUATERNIONS: [&str; 4] = ["q", "quat", "quaternion", "quaternions"];
/// Components of a quaternion as they are called, in the order w x y z.
const COMPONENTS: [[&str; 4]; 4] =
    [["w", "0", "r", "s"], ["x", "1", "i", "x"], ["y", "2", "j", "y"], ["z", "3", "k", "z"]];

/// Refuses columns that nobody reads, but that a coordinate without a column may be meant by.
pub(super) fn check_spelling(table: &Table, machine: &Machine) -> Result<(), FileError> {
    // What was measured otherwise has no pose columns at all.
    if table.columns.iter().any(|c| matches!(&c.meaning, Meaning::Reading(c) if !c.sigma)) {
        return Ok(());
    }
    let turned = table.columns.iter().any(|c| matches!(c.meaning, Meaning::Quaternion(_)));
    let measured: [bool; 6] =
        std::array::from_fn(|k| turned && k >= 3 || table.columns.iter().any(|c| c.meaning == Meaning::Pose(k)));
    let kinds = machine.condition_kinds();
    let foreign: Vec<usize> = (0..table.columns.len())
        .filter(|k| table.columns[*k].foreign(kinds).is_some() && !table.is_remark(*k))
        .collect();
    let units = [machine.length_unit, machine.angle_unit];
    for k in &foreign {
        let (words, unit) = parts(&table.columns[*k].name);
        let mut meant: Vec<String> = Vec::new();
        for coordinate in coordinates(&words, unit).into_iter().filter(|c| !measured[*c]) {
            let own = unit.filter(|unit| unit.dimension == pose_dimension(coordinate));
            meant.push(format!("'{}_{}'", POSE_NAMES[coordinate], own.unwrap_or(units[coordinate / 3]).name));
        }
        if !measured[3..].contains(&true) && unit.is_none() {
            meant.extend(component(&words).map(|name| format!("'{name}'")));
        }
        if !meant.is_empty() {
            let meant = meant.join(" or ");
            return Err(table.column_error(*k, format!("would be taken for a condition; did you mean {meant}?")));
        }
    }
    check_halves(table, machine, &measured, &foreign)
}

/// Refuses what nothing reads in a unit of the half of the pose that was not measured.
fn check_halves(table: &Table, machine: &Machine, measured: &[bool; 6], foreign: &[usize]) -> Result<(), FileError> {
    let controlled = machine.mechanism.controlled();
    for (half, other, what) in [(3..6, 0..3, "angle"), (0..3, 3..6, "coordinate of the position")] {
        if measured[half.clone()].contains(&true)
            || !measured[other].contains(&true)
            || !controlled[half.clone()].contains(&true)
        {
            continue;
        }
        let dimension = pose_dimension(half.start);
        let of_half = |k: &&usize| table.columns[**k].unit.is_some_and(|unit| unit.dimension == dimension);
        let Some((first, unit)) = foreign.iter().find(of_half).and_then(|k| Some((*k, table.columns[*k].unit?.name)))
        else {
            continue;
        };
        let names: Vec<String> = half.map(|k| format!("'{}_{unit}'", POSE_NAMES[k])).collect();
        return Err(table.column_error(
            first,
            format!(
                "is not read, and no {what} of the pose has a column; if it is one, call it {}; if it is a condition, \
                 leave out its unit",
                shortened(&names)
            ),
        ));
    }
    Ok(())
}

/// The words of a name in small letters, without fillers, and its unit.
fn parts(name: &str) -> (Vec<String>, Option<Unit>) {
    let name = without_brackets(name).unwrap_or_else(|| name.to_owned());
    let (base, unit) = match name.rsplit_once('_').and_then(|(base, unit)| Some((base, Unit::named(unit)?))) {
        Some((base, unit)) => (base, Some(unit)),
        None => (name.as_str(), None),
    };
    let words = base.split(|c: char| !c.is_alphanumeric()).map(str::to_lowercase);
    (words.filter(|word| !word.is_empty() && !FILLERS.contains(&word.as_str())).collect(), unit)
}

/// The coordinates that a name may mean, the likeliest first.
fn coordinates(words: &[String], unit: Option<Unit>) -> Vec<usize> {
    let key = words.concat();
    let with_axis = |word: &str| {
        let rest = key.strip_prefix(word).filter(|rest| is_axis(rest));
        rest.or_else(|| key.strip_suffix(word).filter(|rest| is_axis(rest))).and_then(axis)
    };
    let said = |word: &&&str| unit.is_some() || PLAIN.contains(*word);
    let fits = |dimension: Dimension| unit.is_none_or(|unit| unit.dimension == dimension);
    if fits(Dimension::Length)
        && let Some(k) = POSITIONS.iter().filter(said).find_map(|word| with_axis(word))
    {
        return vec![k];
    }
    if !fits(Dimension::Angle) {
        return Vec::new();
    }
    if let Some(k) = TURNS.iter().filter(said).find_map(|word| with_axis(word)) {
        return vec![3 + k];
    }
    let named = ANGLES.iter().find(|(name, _)| *name == key || *name == key.trim_end_matches("angle"));
    let named = named.filter(|(name, _)| unit.is_some() || PLAIN_ANGLES.contains(name));
    named.map_or(Vec::new(), |(_, coordinates)| coordinates.to_vec())
}

fn axis(text: &str) -> Option<usize> {
    ["x", "y", "z"].iter().position(|name| *name == text)
}

fn is_axis(text: &str) -> bool {
    axis(text).is_some()
}

/// The component of a quaternion that a name may mean.
fn component(words: &[String]) -> Option<&'static str> {
    let key = words.concat();
    let rest = |word: &'static &str| key.strip_prefix(*word).map(str::to_owned);
    let found = QUATERNIONS.iter().filter_map(rest);
    let number = |rest: String| COMPONENTS.iter().position(|names| names.contains(&rest.as_str()));
    let k = found.filter_map(number).next()?;
    ["qw", "qx", "qy", "qz"].get(k).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meant(name: &str) -> Vec<&'static str> {
        let (words, unit) = parts(name);
        coordinates(&words, unit).into_iter().map(|k| POSE_NAMES[k]).collect()
    }

    #[test]
    fn coordinates_are_known_by_other_names() {
        for (name, expected) in [
            ("X", "x"),
            ("tx_mm", "x"),
            ("pos_x_mm", "x"),
            ("y_pos_mm", "y"),
            ("Position Z [mm]", "z"),
            ("TZ", "z"),
            ("measured_x_um", "x"),
            ("x_meas", "x"),
            ("roll_deg", "rx"),
            ("Pitch", "ry"),
            ("yaw_angle_mrad", "rz"),
            ("rot_x_deg", "rx"),
            ("x_rotation_rad", "rx"),
            ("theta_y_deg", "ry"),
            ("RZ", "rz"),
            ("alpha_deg", "rx"),
            ("V_deg", "ry"),
            ("γ_deg", "rz"),
            ("ry_tcp_arcsec", "ry"),
            ("EulerZ", "rz"),
        ] {
            assert_eq!(meant(name), [expected], "{name}");
        }
        assert_eq!((meant("a_deg"), meant("C_deg")), (vec!["rx", "rz"], vec!["rz", "rx"]));
        for other in ["alpha", "u", "w_mm", "motor3", "pitch_mm", "humidity", "x_N", "wind_speed", "motor_angle_deg"] {
            assert!(meant(other).is_empty(), "{other}: {:?}", meant(other));
        }
        let of = |name: &str| component(&parts(name).0);
        assert_eq!([of("quat_w"), of("Q0"), of("q_k"), of("quality")], [Some("qw"), Some("qw"), Some("qz"), None]);
    }
}
