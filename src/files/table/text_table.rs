//! A table as columns with meanings and rows of cells.

use std::path::{Path, PathBuf};

use nalgebra::{Quaternion, UnitQuaternion};

use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::mechanism::reader::MOST;
use crate::files::table::cells::{Cells, is_missing};
use crate::files::table::column::{Column, Meaning, ReadingNames, column};
use crate::files::table::writer::CsvTable;

/// A table whose rows all have the length of its header.
#[derive(Debug)]
pub(crate) struct Table {
    pub(crate) path: PathBuf,
    pub(crate) columns: Vec<Column>,
    /// Line in the file and cells, by data row.
    pub(crate) rows: Vec<(u64, Vec<String>)>,
    /// What the user should know of how it was read.
    pub(crate) warnings: Vec<String>,
}

impl Table {
    /// Reads a table and what its columns mean for a machine and for the kinds of reading.
    pub(crate) fn read(path: &Path, machine: &Machine, readings: ReadingNames<'_>) -> Result<Self, FileError> {
        Self::of(path, Cells::read(path)?, machine, readings)
    }

    /// What the columns of a table mean for a machine and for the kinds of reading.
    pub(crate) fn of(
        path: &Path,
        cells: Cells,
        machine: &Machine,
        readings: ReadingNames<'_>,
    ) -> Result<Self, FileError> {
        let (mechanism, joints) = (machine.mechanism.as_ref(), machine.joint_columns());
        let Cells { header, rows, warnings } = cells;
        let mut columns: Vec<Column> = Vec::with_capacity(header.len());
        for name in &header {
            let problem = |problem: String| FileError::Column { path: path.into(), column: name.clone(), problem };
            if let [title, others @ ..] = header.as_slice()
                && !title.is_empty()
                && others.len() > 1
                && others.iter().all(String::is_empty)
            {
                return Err(problem(
                    "is the only name in the first line, which seems to be a title; delete what is above the names of \
                     the columns"
                        .into(),
                ));
            }
            if name.is_empty() {
                return Err(problem("has no name, and cells with content; name it or delete it".into()));
            }
            let of = |name: &str| column(name, &header, mechanism, readings, &joints, machine.condition_kinds());
            if let Some(usual) = without_brackets(name)
                && of(&usual).is_ok_and(|c| !matches!(c.meaning, Meaning::Covariate(_)))
            {
                return Err(problem(format!("would be taken for a condition; write it as '{usual}'")));
            }
            let found = of(name).map_err(problem)?;
            if let Some(other) = columns.iter().find(|c| c.meaning == found.meaning) {
                return Err(problem(if other.name == *name {
                    "appears twice in the header; delete or rename one of them".into()
                } else {
                    format!("means the same as column '{}'; keep one of them", other.name)
                }));
            }
            columns.push(found);
        }
        if rows.is_empty() {
            return Err(no_data_row(path));
        }
        Ok(Self { path: path.into(), columns, rows, warnings })
    }

    /// Some of the columns, as they stand in the file.
    pub(crate) fn excerpt(&self, columns: &[usize]) -> CsvTable {
        let cells = |(_, cells): &(u64, Vec<String>)| columns.iter().map(|k| cells[*k].clone()).collect();
        CsvTable {
            comments: Vec::new(),
            header: columns.iter().map(|k| self.columns[*k].name.clone()).collect(),
            rows: self.rows.iter().map(cells).collect(),
        }
    }

    /// True for a column of no known meaning that holds no number at all, such as remarks.
    pub(crate) fn is_remark(&self, column: usize) -> bool {
        let Column { meaning, unit, .. } = &self.columns[column];
        let no_number =
            |(_, cells): &(u64, Vec<String>)| is_missing(&cells[column]) || cells[column].parse::<f64>().is_err();
        matches!(meaning, Meaning::Covariate(_)) && unit.is_none() && self.rows.iter().all(no_number)
    }

    /// The error of a column.
    pub(crate) fn column_error(&self, column: usize, problem: impl Into<String>) -> FileError {
        FileError::Column {
            path: self.path.clone(),
            column: self.columns[column].name.clone(),
            problem: problem.into(),
        }
    }

    /// The error of one cell.
    pub(crate) fn cell_error(&self, row: usize, column: usize, problem: impl Into<String>) -> FileError {
        FileError::Cell {
            path: self.path.clone(),
            row,
            line: self.rows[row].0,
            column: self.columns[column].name.clone(),
            value: self.rows[row].1[column].clone(),
            problem: problem.into(),
        }
    }

    /// The number in a cell, SI; `None` if the cell is empty.
    pub(crate) fn number(&self, row: usize, column: usize) -> Result<Option<f64>, FileError> {
        if is_missing(&self.rows[row].1[column]) {
            return Ok(None);
        }
        self.parsed(row, column, "leave the cell empty if nothing was measured").map(Some)
    }

    /// The number in a cell that must not be empty.
    pub(crate) fn required(&self, row: usize, column: usize) -> Result<f64, FileError> {
        if is_missing(&self.rows[row].1[column]) {
            return Err(self.cell_error(row, column, "must not be empty; fill it in or delete the row"));
        }
        self.parsed(row, column, "correct it or delete the row")
    }

    fn parsed(&self, row: usize, column: usize, advice: &str) -> Result<f64, FileError> {
        let text = &self.rows[row].1[column];
        let error = |problem: &str| self.cell_error(row, column, format!("{problem}; {advice}"));
        let decimal_comma = || text.replacen(',', ".", 1).parse::<f64>().is_ok();
        let value: f64 = text.parse().map_err(|_| match decimal_comma() {
            true => self.cell_error(row, column, "has a decimal comma; save the table with decimal points in numbers"),
            false => error("is not a number"),
        })?;
        let value = self.columns[column].unit.map_or(value, |u| u.to_si(value));
        let value = self.columns[column].joint.as_ref().map_or(value, |j| j.length(value));
        match value {
            _ if !value.is_finite() => Err(error("is not a finite number")),
            _ if value.abs() > MOST => Err(error("is too far from zero for any machine")),
            _ => Ok(value),
        }
    }

    /// The quaternion in four columns w x y z; `None` if their cells are empty.
    pub(crate) fn quaternion(
        &self,
        row: usize,
        columns: &[usize; 4],
    ) -> Result<Option<UnitQuaternion<f64>>, FileError> {
        let mut q = [0.0; 4];
        let mut filled = 0;
        for (component, column) in q.iter_mut().zip(columns) {
            if let Some(v) = self.number(row, *column)? {
                *component = v;
                filled += 1;
            }
        }
        match filled {
            0 => return Ok(None),
            4 => {}
            _ => {
                let problem = "belongs to a quaternion that is only partly filled; fill all four cells or none";
                return Err(self.cell_error(row, columns[0], problem));
            }
        }
        let quaternion = Quaternion::new(q[0], q[1], q[2], q[3]);
        if !((quaternion.norm() - 1.0).abs() <= 1e-3) {
            let norm = quaternion.norm();
            let problem = format!("belongs to a quaternion of length {norm:.6}; it must be 1, correct qw, qx, qy, qz");
            return Err(self.cell_error(row, columns[0], problem));
        }
        Ok(Some(UnitQuaternion::from_quaternion(quaternion)))
    }

    /// The columns of a quaternion w x y z; `None` if there is none.
    pub(crate) fn quaternion_columns(&self) -> Result<Option<[usize; 4]>, FileError> {
        let find = |k| self.columns.iter().position(|c| c.meaning == Meaning::Quaternion(k));
        let header = |problem: &str| FileError::Header { path: self.path.clone(), problem: problem.into() };
        let columns = match [find(0), find(1), find(2), find(3)] {
            [Some(w), Some(x), Some(y), Some(z)] => [w, x, y, z],
            [None, None, None, None] => return Ok(None),
            _ => return Err(header("a quaternion needs all of qw, qx, qy and qz")),
        };
        if self.columns.iter().any(|c| matches!(c.meaning, Meaning::Pose(3..))) {
            return Err(header("has both a quaternion and angles; keep one of them"));
        }
        Ok(Some(columns))
    }
}

/// The error of a table that ends with its header.
pub(crate) fn no_data_row(path: &Path) -> FileError {
    FileError::Header { path: path.into(), problem: "there is a header but no data row; add rows below it".into() }
}

/// `x_mm` for `X [mm]` or `x (mm)`: how a name with its unit in brackets is written here.
pub(crate) fn without_brackets(name: &str) -> Option<String> {
    let (stem, unit) = name.strip_suffix([']', ')'])?.rsplit_once(['[', '('])?;
    let stem = stem.trim().to_lowercase().replace(' ', "_");
    (!stem.is_empty() && !unit.trim().is_empty()).then(|| format!("{stem}_{}", unit.trim()))
}
