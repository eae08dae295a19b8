//! Lists of poses, and lists of parameter errors.

use std::path::Path;

use crate::conditions::Conditions;
use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::readings::reading_columns;
use crate::files::table::cells::Cells;
use crate::files::table::column::{Meaning, POSE_NAMES, pose_dimension};
use crate::files::table::spelling::check_spelling;
use crate::files::table::states::States;
use crate::files::table::text_table::{Table, no_data_row};
use crate::files::table::writer::CsvTable;
use crate::mechanism::{Mechanism, ParameterSpec};
use crate::pose::Pose;
use crate::units::{Dimension, Unit};

/// A pose of a list.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedPose {
    /// Label from the file.
    pub id: Option<String>,
    /// The pose.
    pub pose: Pose,
    /// Operating state, from the other columns; the joints before are not known.
    pub conditions: Conditions,
}

/// A list of poses, read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PoseList {
    /// The poses in order.
    pub poses: Vec<ListedPose>,
    /// The columns of covariates and times as they stand in the file.
    pub covariates: CsvTable,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

/// Reads a list of poses: columns x, y, z, rx, ry, rz with units, or a quaternion instead of the angles. Other
/// columns with numbers are covariates.
///
/// # Errors
/// [`FileError`] naming row, column and what to do.
pub fn read_poses(path: impl AsRef<Path>, machine: &Machine) -> Result<Vec<ListedPose>, FileError> {
    Ok(read_pose_list(path, machine)?.poses)
}

/// Reads the same with the columns of the operating states as they stand.
///
/// # Errors
/// As [`read_poses`].
pub fn read_pose_list(path: impl AsRef<Path>, machine: &Machine) -> Result<PoseList, FileError> {
    let path = path.as_ref();
    let table = Table::read(path, machine, &reading_columns(None))?;
    check_spelling(&table, machine)?;
    let find = |meaning: Meaning| table.columns.iter().position(|c| c.meaning == meaning);
    let quaternion = table.quaternion_columns()?;
    let coordinates = if quaternion.is_some() { 3 } else { 6 };
    let controlled = machine.mechanism.controlled();
    let mut columns = Vec::new();
    for (k, name) in POSE_NAMES.iter().enumerate().take(coordinates) {
        let column = find(Meaning::Pose(k));
        if column.is_none() && controlled[k] {
            return Err(FileError::Header {
                path: path.into(),
                problem: format!("a list of poses needs a column '{name}_…' ({})", pose_dimension(k).choices()),
            });
        }
        columns.push(column);
    }
    // What the joints do not control need not be stated; it is as at home.
    let home = machine.convention.coordinates(&machine.mechanism.home());
    let id = find(Meaning::Id);
    let mut poses = Vec::with_capacity(table.rows.len());
    let States { states, ignored, warnings } = States::read(&table, machine)?;
    for (row, conditions) in states.into_iter().enumerate() {
        let mut q = home;
        for (k, column) in columns.iter().enumerate() {
            if let Some(column) = column {
                q[k] = table.required(row, *column)?;
            }
        }
        if let Some(columns) = &quaternion {
            let empty = || table.cell_error(row, columns[0], "must not be empty; fill it in or delete the row");
            let turn = table.quaternion(row, columns)?.ok_or_else(empty)?;
            q[3..].copy_from_slice(machine.convention.angles(&turn.to_rotation_matrix()).as_slice());
        }
        let id = id.map(|k| table.rows[row].1[k].clone()).filter(|t| !t.is_empty());
        poses.push(ListedPose { id, pose: machine.convention.pose(&q), conditions });
    }
    let is_state =
        |k: &usize| matches!(table.columns[*k].meaning, Meaning::Covariate(_) | Meaning::Clock) && !ignored.contains(k);
    let kept: Vec<usize> = (0..table.columns.len()).filter(is_state).collect();
    let covariates = table.excerpt(&kept);
    Ok(PoseList { poses, covariates, warnings })
}

/// Reads parameter errors (`leg,xA_mm,…,h_mm`) in the order of the parameters of a mechanism, SI; parameters
/// that are not listed have none. Each leg and each column stands once. A column is the name of a parameter without the
/// number of its leg, and a unit of its dimension; a plain number has none.
///
/// # Errors
/// [`FileError`] naming row, column and what to do.
pub fn read_parameter_errors(path: impl AsRef<Path>, mechanism: &dyn Mechanism) -> Result<Vec<f64>, FileError> {
    let path = path.as_ref();
    let Cells { header, rows, .. } = Cells::read(path)?;
    let leg_column = header.iter().position(|h| h == "leg").ok_or_else(|| FileError::Header {
        path: path.into(),
        problem: "parameter errors need a column 'leg'".into(),
    })?;
    let specs = mechanism.parameters();
    let legs = specs.iter().filter_map(|s| s.role.leg()).max().map_or(0, |last| last + 1);
    let of_leg = |stem: &str, leg: usize| specs.iter().position(|s| is_called(s, stem, leg));
    let mut errors = vec![0.0; specs.len()];
    let mut listed = vec![false; legs];
    if rows.is_empty() {
        return Err(no_data_row(path));
    }
    let columns = error_columns(path, &header, specs, legs)?;
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
            return Err(cell_error(leg_column, "appears twice; keep one row for each leg"));
        }
        for (k, column) in columns.iter().enumerate() {
            let Some((stem, unit)) = column else { continue };
            let value: f64 =
                cells[k].parse().map_err(|_| cell_error(k, "is not a number; write 0 if there is no error"))?;
            if !value.is_finite() {
                return Err(cell_error(k, "is not a finite number"));
            }
            match of_leg(stem, leg - 1) {
                Some(p) => errors[p] = unit.to_si(value),
                None if value == 0.0 => {}
                None => return Err(cell_error(k, "belongs to a leg that has no such parameter; write 0")),
            }
        }
    }
    Ok(errors)
}

/// Parameter (without the number of its leg) and unit of each column, `None` for that of the legs.
fn error_columns(
    path: &Path,
    header: &[String],
    specs: &[ParameterSpec],
    legs: usize,
) -> Result<Vec<Option<(String, Unit)>>, FileError> {
    let column_error =
        |column: &str, problem: String| FileError::Column { path: path.into(), column: column.into(), problem };
    let mut units = Vec::with_capacity(header.len());
    for (k, name) in header.iter().enumerate() {
        let stem = |text: &str| text.rsplit_once('_').map_or(text, |(stem, _)| stem).to_owned();
        if let Some(other) = header[..k].iter().find(|other| stem(other) == stem(name)) {
            return Err(column_error(name, format!("means the same as column '{other}'; keep one of them")));
        }
        if name == "leg" {
            units.push(None);
            continue;
        }
        let with_unit = name.rsplit_once('_').unwrap_or((name, ""));
        // A parameter without dimension has a name without unit.
        let find =
            |stem: &str| (0..legs).find_map(|leg| specs.iter().find(|s| is_called(s, stem, leg))).map(|s| s.dimension);
        let (stem, dimension) = match (find(name), find(with_unit.0)) {
            (Some(Dimension::None), _) => (name.as_str(), Dimension::None),
            (_, Some(dimension)) => (with_unit.0, dimension),
            _ => {
                let known = stems(specs).join(" ");
                return Err(column_error(name, format!("is not a parameter of a leg; use {known} with a unit")));
            }
        };
        let unit = match dimension {
            Dimension::None => Unit::si(dimension),
            _ => Unit::of(dimension, with_unit.1).map_err(|e| column_error(name, e.to_string()))?,
        };
        units.push(Some((stem.to_owned(), unit)));
    }
    Ok(units)
}

/// True for the parameter of a leg (from 0) whose name without the number of the leg is `stem`.
fn is_called(spec: &ParameterSpec, stem: &str, leg: usize) -> bool {
    let numbered = |rest: &str| rest == (leg + 1).to_string();
    spec.role.leg() == Some(leg) && spec.name.strip_prefix(stem).is_some_and(numbered)
}

/// Names of the parameters of legs without their numbers, each once.
fn stems(specs: &[ParameterSpec]) -> Vec<&str> {
    let mut stems = Vec::new();
    for spec in specs {
        let number = spec.role.leg().map(|leg| (leg + 1).to_string());
        if let Some(stem) = number.and_then(|n| spec.name.strip_suffix(n.as_str())).filter(|s| !stems.contains(s)) {
            stems.push(stem);
        }
    }
    stems
}
