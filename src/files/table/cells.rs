//! Cells of a table as people have it: saved by a spreadsheet, by pandas, by the program of an instrument.
//!
//! Columns are separated by commas, semicolons, tabs or blanks, whichever the header shows, or by what a first line `sep=;`
//! states. Lines that begin with `#` or `//` are comments. Rows and columns without content are none, and neither is a first
//! column without a name that counts the rows. A first row of units gives the columns theirs. What is left out or added is
//! said, unless it was empty.

use std::path::Path;

use crate::files::error::{FileError, read_text};
use crate::files::format::begins_a_mechanism;
use crate::units::Unit;

/// A table before its columns have a meaning: every row has as many cells as the header.
#[derive(Clone, Debug)]
pub(crate) struct Cells {
    pub(crate) header: Vec<String>,
    /// Line in the file and cells, by data row.
    pub(crate) rows: Vec<(u64, Vec<String>)>,
    /// What the user should know of how it was read.
    pub(crate) warnings: Vec<String>,
}

/// True for a cell in which nothing was measured: empty, or what other programs write for it.
pub(crate) fn is_missing(cell: &str) -> bool {
    cell.is_empty() || ["nan", "na", "n/a", "null"].iter().any(|word| cell.eq_ignore_ascii_case(word))
}

impl Cells {
    /// Reads the cells of a file.
    ///
    /// # Errors
    /// [`FileError`] naming the row and what to do.
    pub(crate) fn read(path: &Path) -> Result<Self, FileError> {
        let text = read_text(path)?;
        let wrong = |problem: String| FileError::Header { path: path.into(), problem };
        if begins_a_mechanism(&text) {
            let problem = "is a mechanism file and not a table; name the mechanism file first and the table after it";
            return Err(wrong(problem.into()));
        }
        let (separator, mut rows) = split(&text).map_err(wrong)?;
        if rows.is_empty() {
            return Err(wrong("there is no header line; the first line names the columns".into()));
        }
        let (_, header) = rows.remove(0);
        let mut cells = Self { header, rows, warnings: Vec::new() };
        cells.same_length(path, separator)?;
        cells.without_empty_columns();
        cells.with_row_of_units().map_err(wrong)?;
        cells.without_index();
        cells.count_missing();
        Ok(cells)
    }

    /// Cuts empty cells beyond the header, and refuses rows of another length.
    fn same_length(&mut self, path: &Path, separator: Separator) -> Result<(), FileError> {
        let expected = self.header.len();
        for (row, (line, cells)) in self.rows.iter_mut().enumerate() {
            if cells.get(expected..).is_some_and(|beyond| beyond.iter().all(String::is_empty)) {
                cells.truncate(expected);
            }
            let found = cells.len();
            if found == expected {
                continue;
            }
            let whole = |cell: &String| cell.parse::<f64>().is_ok_and(|v| v.fract() == 0.0);
            if separator == Separator::Byte(b',')
                && found > expected
                && cells.iter().filter(|c| whole(c)).count() > expected
            {
                let problem = format!(
                    "data row {row} (line {line}) has {found} cells, the header has {expected}: decimal commas? save the \
                     table with decimal points, or with semicolons between columns and points in numbers"
                );
                return Err(FileError::Header { path: path.into(), problem });
            }
            return Err(FileError::RowLength { path: path.into(), row, line: *line, found, expected });
        }
        Ok(())
    }

    fn without_empty_columns(&mut self) {
        let is_used = |k: usize| !self.header[k].is_empty() || self.rows.iter().any(|(_, cells)| !cells[k].is_empty());
        let kept: Vec<bool> = (0..self.header.len()).map(is_used).collect();
        self.keep(&kept);
    }

    /// The index that pandas and spreadsheets write: a first column without a name, whose whole numbers go up.
    fn without_index(&mut self) {
        let number = |(_, cells): &(u64, Vec<String>)| cells.first().and_then(|cell| cell.parse::<i64>().ok());
        let numbers: Option<Vec<i64>> = self.rows.iter().map(number).collect();
        let unnamed = self.header.first().is_some_and(|name| name.is_empty() || name == "Unnamed: 0");
        let counts = |numbers: &Vec<i64>| numbers.windows(2).all(|pair| pair[0] < pair[1]);
        if unnamed && !self.rows.is_empty() && numbers.as_ref().is_some_and(counts) {
            let kept: Vec<bool> = (0..self.header.len()).map(|k| k > 0).collect();
            self.keep(&kept);
            self.warnings.push("the first column has no name and counts the rows; it is not used".into());
        }
    }

    fn keep(&mut self, kept: &[bool]) {
        if kept.iter().all(|k| *k) {
            return;
        }
        for cells in std::iter::once(&mut self.header).chain(self.rows.iter_mut().map(|(_, cells)| cells)) {
            let mut kept = kept.iter();
            cells.retain(|_| kept.next().copied().unwrap_or(true));
        }
    }

    /// Takes a first row of units into the names.
    fn with_row_of_units(&mut self) -> Result<(), String> {
        let Some((line, units)) = self.rows.first() else { return Ok(()) };
        let units: Vec<&str> = units.iter().map(|cell| cell.trim_matches(['[', ']', '(', ')', ' '])).collect();
        let is_none = |unit: &str| matches!(unit, "" | "-" | "1");
        let known = |unit: &&str| is_none(unit) || Unit::named(unit).is_some();
        if !units.iter().all(known) || units.iter().all(|unit| is_none(unit)) {
            return Ok(());
        }
        for (name, unit) in self.header.iter_mut().zip(&units).filter(|(_, unit)| !is_none(unit)) {
            match name.rsplit_once('_').and_then(|(_, stated)| Unit::named(stated)) {
                Some(stated) if Unit::named(unit) != Some(stated) => {
                    return Err(format!(
                        "column '{name}': line {line} states another unit, '{unit}'; correct one of them"
                    ));
                }
                Some(_) => {}
                None => *name = format!("{name}_{unit}"),
            }
        }
        let names: Vec<&str> = self.header.iter().map(String::as_str).filter(|name| !name.is_empty()).collect();
        self.warnings.push(format!("line {line} states units; the columns are read as {}", names.join(", ")));
        self.rows.remove(0);
        Ok(())
    }

    fn count_missing(&mut self) {
        let missing = |cell: &&String| !cell.is_empty() && is_missing(cell);
        let count = self.rows.iter().flat_map(|(_, cells)| cells).filter(missing).count();
        if count > 0 {
            let cells = if count == 1 { "1 cell holds" } else { &format!("{count} cells hold") };
            self.warnings.push(format!("{cells} nan or the like and count as not measured"));
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Separator {
    Byte(u8),
    Blanks,
}

/// Rows with something in them, by line, and what separates their cells.
#[allow(clippy::type_complexity)]
fn split(text: &str) -> Result<(Separator, Vec<(u64, Vec<String>)>), String> {
    let (stated, text) = match text.split_once('\n') {
        Some((first, rest)) => match first.trim().trim_matches('"').strip_prefix("sep=") {
            Some(stated) => (Some(stated.bytes().next().unwrap_or(b'\t')), rest),
            None => (None, text),
        },
        None => (None, text),
    };
    let is_comment = |line: &str| line.trim_start().starts_with('#') || line.trim_start().starts_with("//");
    // Comments become empty lines, so that lines keep their numbers.
    let text: String = text.lines().flat_map(|line| [if is_comment(line) { "" } else { line }, "\n"]).collect();
    let header = text.lines().find(|line| line.contains(|c: char| !c.is_whitespace() && !",;\"".contains(c)));
    let separator = stated.map_or_else(|| separator_of(header.unwrap_or("")), Separator::Byte);
    let skipped = u64::from(stated.is_some());
    let rows = match separator {
        Separator::Blanks => (1..)
            .zip(text.lines())
            .map(|(line, cells)| {
                (line + skipped, cells.split_whitespace().map(|c| c.trim_matches('"').to_owned()).collect())
            })
            .collect::<Vec<(u64, Vec<String>)>>(),
        Separator::Byte(byte) => {
            let mut reader = csv::ReaderBuilder::new()
                .delimiter(byte)
                .flexible(true)
                .trim(csv::Trim::All)
                .has_headers(false)
                .from_reader(text.as_bytes());
            let row = |record: csv::StringRecord| {
                let line = record.position().map_or(0, csv::Position::line);
                (line + skipped, record.iter().map(str::to_owned).collect())
            };
            let rows: Result<_, csv::Error> = reader.records().map(|record| record.map(row)).collect();
            rows.map_err(|e| format!("cannot be read as CSV: {e}"))?
        }
    };
    Ok((separator, rows.into_iter().filter(|(_, cells)| cells.iter().any(|c| !c.is_empty())).collect()))
}

/// What separates the names of a header.
fn separator_of(header: &str) -> Separator {
    let count = |byte: u8| header.bytes().filter(|b| *b == byte).count();
    let most = [b',', b';', b'\t'].into_iter().max_by_key(|byte| (count(*byte), *byte == b','));
    match most {
        Some(byte) if count(byte) > 0 => Separator::Byte(byte),
        _ if header.split_whitespace().nth(1).is_some() => Separator::Blanks,
        _ => Separator::Byte(b','),
    }
}
