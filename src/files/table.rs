//! A CSV file as columns with meanings and rows of cells.

use std::path::{Path, PathBuf};

use super::column::{Column, column};
use super::error::{FileError, read_text};
use crate::mechanism::Mechanism;

/// A table whose rows all have the length of its header.
pub(super) struct Table {
    pub(super) path: PathBuf,
    pub(super) columns: Vec<Column>,
    /// Line in the file and cells, by data row.
    pub(super) rows: Vec<(u64, Vec<String>)>,
}

impl Table {
    /// Reads a table and what its columns mean for a mechanism.
    pub(super) fn read(path: &Path, mechanism: &dyn Mechanism, targets: &[String]) -> Result<Self, FileError> {
        let (header, rows) = read_cells(path)?;
        let mut columns: Vec<Column> = Vec::with_capacity(header.len());
        for name in &header {
            let problem = |problem: String| FileError::Column { path: path.into(), column: name.clone(), problem };
            if name.is_empty() {
                return Err(problem("has no name".into()));
            }
            let found = column(name, mechanism, targets).map_err(problem)?;
            if let Some(other) = columns.iter().find(|c| c.meaning == found.meaning) {
                return Err(problem(if other.name == *name {
                    "stands twice in the header".into()
                } else {
                    format!("means the same as column '{}'", other.name)
                }));
            }
            columns.push(found);
        }
        if rows.is_empty() {
            return Err(FileError::Header { path: path.into(), problem: "there is a header but no data row".into() });
        }
        Ok(Self { path: path.into(), columns, rows })
    }

    /// The error of one cell.
    pub(super) fn cell_error(&self, row: usize, column: usize, problem: impl Into<String>) -> FileError {
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
    pub(super) fn number(&self, row: usize, column: usize) -> Result<Option<f64>, FileError> {
        let text = &self.rows[row].1[column];
        if text.is_empty() {
            return Ok(None);
        }
        let value: f64 = text.parse().map_err(|_| self.cell_error(row, column, "is not a number"))?;
        if !value.is_finite() {
            let advice = "is not a finite number; leave the cell empty if nothing was measured";
            return Err(self.cell_error(row, column, advice));
        }
        Ok(Some(self.columns[column].unit.map_or(value, |u| u.to_si(value))))
    }

    /// The number in a cell that must not be empty.
    pub(super) fn required(&self, row: usize, column: usize) -> Result<f64, FileError> {
        self.number(row, column)?.ok_or_else(|| self.cell_error(row, column, "must not be empty"))
    }
}

/// Header and rows of a CSV file, with the line of each row.
#[allow(clippy::type_complexity)]
pub(super) fn read_cells(path: &Path) -> Result<(Vec<String>, Vec<(u64, Vec<String>)>), FileError> {
    let text = read_text(path)?;
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .flexible(true)
        .trim(csv::Trim::All)
        .has_headers(false)
        .from_reader(text.as_bytes());
    let mut rows: Vec<(u64, Vec<String>)> = Vec::new();
    for record in reader.records() {
        let record = record
            .map_err(|e| FileError::Header { path: path.into(), problem: format!("cannot be read as CSV: {e}") })?;
        let line = record.position().map_or(0, csv::Position::line);
        // A line of blanks between rows is no row.
        if record.len() == 1 && record.get(0).is_some_and(str::is_empty) {
            continue;
        }
        rows.push((line, record.iter().map(str::to_owned).collect()));
    }
    if rows.is_empty() {
        return Err(FileError::Header { path: path.into(), problem: "there is no header line".into() });
    }
    let (_, header) = rows.remove(0);
    for (row, (line, cells)) in rows.iter().enumerate() {
        if cells.len() != header.len() {
            let (found, expected) = (cells.len(), header.len());
            return Err(FileError::RowLength { path: path.into(), row, line: *line, found, expected });
        }
    }
    Ok((header, rows))
}
