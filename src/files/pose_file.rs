//! Lists of poses, and lists of parameter errors.

use std::path::Path;

use super::column::{Meaning, POSE_NAMES, pose_dimension};
use super::error::FileError;
use super::machine::Machine;
use super::table::{Table, read_cells};
use crate::mechanism::{Mechanism, ParameterRole};
use crate::pose::Pose;
use crate::units::{Dimension, Unit};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// A pose of a list.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedPose {
    /// Label from the file.
    pub id: Option<String>,
    /// The pose.
    pub pose: Pose,
}

/// Reads a list of poses: columns x, y, z, rx, ry, rz with units, or a quaternion instead of the angles. Other
/// columns are passed over.
///
/// # Errors
/// [`FileError`] naming row, column and what to do.
pub fn read_poses(path: impl AsRef<Path>, machine: &Machine) -> Result<Vec<ListedPose>, FileError> {
    let path = path.as_ref();
    let table = Table::read(path, machine.mechanism.as_ref(), &[])?;
    let find = |meaning: Meaning| table.columns.iter().position(|c| c.meaning == meaning);
    let quaternion: Option<Vec<usize>> = (0..4).map(|k| find(Meaning::Quaternion(k))).collect();
    let coordinates = if quaternion.is_some() { 3 } else { 6 };
    let mut columns = Vec::new();
    for (k, name) in POSE_NAMES.iter().enumerate().take(coordinates) {
        columns.push(find(Meaning::Pose(k)).ok_or_else(|| FileError::Header {
            path: path.into(),
            problem: format!("a list of poses needs a column '{name}_…' ({})", pose_dimension(k).choices()),
        })?);
    }
    let id = find(Meaning::Id);
    let mut poses = Vec::with_capacity(table.rows.len());
    for row in 0..table.rows.len() {
        let mut q = [0.0; 6];
        for (k, column) in columns.iter().enumerate() {
            q[k] = table.required(row, *column)?;
        }
        if let Some(quaternion) = &quaternion {
            let v = quaternion.iter().map(|c| table.required(row, *c)).collect::<Result<Vec<f64>, _>>()?;
            let turn = UnitQuaternion::from_quaternion(Quaternion::new(v[0], v[1], v[2], v[3]));
            let angles: Vector3<f64> = machine.convention.angles(&turn.to_rotation_matrix());
            q[3..].copy_from_slice(angles.as_slice());
        }
        let id = id.map(|k| table.rows[row].1[k].clone()).filter(|t| !t.is_empty());
        poses.push(ListedPose { id, pose: machine.convention.pose(&q) });
    }
    Ok(poses)
}

/// Reads parameter errors (`leg,xA_mm,…,h_mm`) in the order of the parameters of a mechanism, SI; parameters
/// that are not listed have none.
///
/// # Errors
/// [`FileError`] naming row, column and what to do.
pub fn read_parameter_errors(path: impl AsRef<Path>, mechanism: &dyn Mechanism) -> Result<Vec<f64>, FileError> {
    let path = path.as_ref();
    let (header, rows) = read_cells(path)?;
    let column_error =
        |column: &str, problem: String| FileError::Column { path: path.into(), column: column.into(), problem };
    let leg_column = header.iter().position(|h| h == "leg").ok_or_else(|| FileError::Header {
        path: path.into(),
        problem: "parameter errors need a column 'leg'".into(),
    })?;
    let specs = mechanism.parameters();
    let legs = specs.iter().filter(|s| matches!(s.role, ParameterRole::JointOffset { .. })).count();
    let mut errors = vec![0.0; specs.len()];
    let mut units = Vec::new();
    for name in &header {
        if name == "leg" {
            units.push(None);
            continue;
        }
        let (stem, unit) = name.rsplit_once('_').unwrap_or((name, ""));
        let unit = Unit::of(Dimension::Length, unit).map_err(|e| column_error(name, e.to_string()))?;
        if !specs.iter().any(|s| s.name == format!("{stem}1")) {
            return Err(column_error(name, "is no parameter of a leg; use xA yA zA h xB yB zB with a unit".into()));
        }
        units.push(Some((stem.to_owned(), unit)));
    }
    for (row, (line, cells)) in rows.iter().enumerate() {
        let cell_error = |k: usize, problem: &str| FileError::Cell {
            path: path.into(),
            row,
            line: *line,
            column: header[k].clone(),
            value: cells[k].clone(),
            problem: problem.into(),
        };
        let leg: usize = cells[leg_column].parse().map_err(|_| cell_error(leg_column, "is not the number of a leg"))?;
        if leg == 0 || leg > legs {
            return Err(cell_error(leg_column, &format!("is not a leg; legs are 1 to {legs}")));
        }
        for (k, unit) in units.iter().enumerate() {
            let Some((stem, unit)) = unit else { continue };
            let value: f64 = cells[k].parse().map_err(|_| cell_error(k, "is not a number"))?;
            if !value.is_finite() {
                return Err(cell_error(k, "is not a finite number"));
            }
            if let Some(p) = specs.iter().position(|s| s.name == format!("{stem}{leg}")) {
                errors[p] = unit.to_si(value);
            }
        }
    }
    Ok(errors)
}
