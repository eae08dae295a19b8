//! Lists of poses, and lists of parameter errors.

use std::path::Path;

use super::column::{Meaning, POSE_NAMES, pose_dimension};
use super::error::FileError;
use super::machine::Machine;
use super::table::{Table, no_data_row, read_cells};
use crate::mechanism::{Mechanism, ParameterRole};
use crate::pose::Pose;
use crate::units::{Dimension, Unit};

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
    let table = Table::read(path, machine, &[])?;
    let find = |meaning: Meaning| table.columns.iter().position(|c| c.meaning == meaning);
    let quaternion = table.quaternion_columns()?;
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
        if let Some(columns) = &quaternion {
            let empty = || table.cell_error(row, columns[0], "must not be empty; fill it in or delete the row");
            let turn = table.quaternion(row, columns)?.ok_or_else(empty)?;
            q[3..].copy_from_slice(machine.convention.angles(&turn.to_rotation_matrix()).as_slice());
        }
        let id = id.map(|k| table.rows[row].1[k].clone()).filter(|t| !t.is_empty());
        poses.push(ListedPose { id, pose: machine.convention.pose(&q) });
    }
    Ok(poses)
}

/// Reads parameter errors (`leg,xA_mm,…,h_mm`) in the order of the parameters of a mechanism, SI; parameters
/// that are not listed have none. Each leg and each column stands once.
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
    let mut listed = vec![false; legs];
    let mut units = Vec::new();
    if rows.is_empty() {
        return Err(no_data_row(path));
    }
    for (k, name) in header.iter().enumerate() {
        let stem = |text: &str| text.rsplit_once('_').map_or(text, |(stem, _)| stem).to_owned();
        if let Some(other) = header[..k].iter().find(|other| stem(other) == stem(name)) {
            return Err(column_error(name, format!("means the same as column '{other}'; keep one of them")));
        }
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
        let bad_leg = format!("is not a leg; legs are numbered from 1 to {legs}");
        let leg: usize = cells[leg_column].parse().map_err(|_| cell_error(leg_column, &bad_leg))?;
        if leg == 0 || leg > legs {
            return Err(cell_error(leg_column, &bad_leg));
        }
        if std::mem::replace(&mut listed[leg - 1], true) {
            return Err(cell_error(leg_column, "stands twice; keep one row for each leg"));
        }
        for (k, unit) in units.iter().enumerate() {
            let Some((stem, unit)) = unit else { continue };
            let value: f64 =
                cells[k].parse().map_err(|_| cell_error(k, "is not a number; write 0 if there is no error"))?;
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
