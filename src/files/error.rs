//! Errors of files.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use thiserror::Error;

use crate::files::finding::{Finding, findings_text};
use crate::files::outputs::is_standard;
use crate::mechanism::{GeometryError, KinematicsError};
use crate::units::UnitError;

/// Errors of files; every message names the file, the place and the remedy.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FileError {
    /// It cannot be read.
    #[error("{}: cannot be read: {cause}; check its name and permissions", path.display())]
    Read {
        /// File.
        path: PathBuf,
        /// Error of the operating system.
        cause: std::io::Error,
    },
    /// It is a folder.
    #[error("{}: is a folder; name a file", path.display())]
    Folder {
        /// Folder.
        path: PathBuf,
    },
    /// It has nothing in it.
    #[error("{}: the file is empty; check that it is the right one", path.display())]
    Empty {
        /// File.
        path: PathBuf,
    },
    /// It is not text.
    #[error("{}: line {line}: is not UTF-8 text (first bad byte at {offset}); save it as UTF-8", path.display())]
    Encoding {
        /// File.
        path: PathBuf,
        /// Line of the first bad byte, from 1.
        line: usize,
        /// Offset of the first bad byte.
        offset: usize,
    },
    /// It is not TOML, or a key is unknown, missing or of the wrong type.
    #[error("{}: {message}", path.display())]
    Toml {
        /// File.
        path: PathBuf,
        /// Line, column, excerpt and reason.
        message: String,
    },
    /// A URDF file is not a mechanism that can be read; every finding names its element and the remedy.
    #[error("{}", findings_text(path, findings))]
    Urdf {
        /// File.
        path: PathBuf,
        /// Problems found in the file.
        findings: Vec<Finding>,
    },
    /// A value of a mechanism file is not acceptable.
    #[error("{}: {place}: {problem}", path.display())]
    Value {
        /// File.
        path: PathBuf,
        /// Section and key.
        place: String,
        /// The problem and its remedy.
        problem: String,
    },
    /// A unit of a mechanism file.
    #[error("{}: {place}: {cause}", path.display())]
    Unit {
        /// File.
        path: PathBuf,
        /// Key.
        place: &'static str,
        /// Which units there are.
        cause: UnitError,
    },
    /// The legs are no mechanism.
    #[error("{}: {cause}", path.display())]
    Geometry {
        /// File.
        path: PathBuf,
        /// The problem.
        cause: GeometryError,
    },
    /// A header of a table.
    #[error("{}: column '{column}': {problem}", path.display())]
    Column {
        /// File.
        path: PathBuf,
        /// Column as it is named in the file.
        column: String,
        /// The problem and its remedy.
        problem: String,
    },
    /// The header as a whole.
    #[error("{}: {problem}", path.display())]
    Header {
        /// File.
        path: PathBuf,
        /// The problem and its remedy.
        problem: String,
    },
    /// A row has too few or too many cells.
    #[error(
        "{}: data row {row} (line {line}) has {found} cells, the header has {expected}; write one cell for each \
         column, empty where there is nothing",
        path.display()
    )]
    RowLength {
        /// File.
        path: PathBuf,
        /// 0-based data row.
        row: usize,
        /// Line in the file.
        line: u64,
        /// Cells found.
        found: usize,
        /// Cells of the header.
        expected: usize,
    },
    /// One cell.
    #[error("{}: data row {row} (line {line}), column '{column}': '{value}' {problem}", path.display())]
    Cell {
        /// File.
        path: PathBuf,
        /// 0-based data row.
        row: usize,
        /// Line in the file.
        line: u64,
        /// Column.
        column: String,
        /// Content of the cell.
        value: String,
        /// The problem.
        problem: String,
    },
    /// The pose of a row has no joints.
    #[error("{}: data row {row}: {cause}", path.display())]
    Kinematics {
        /// File.
        path: PathBuf,
        /// 0-based data row.
        row: usize,
        /// The problem.
        cause: KinematicsError,
    },
    /// An output cannot be written; nothing was.
    #[error("{}: cannot be written: {cause}; nothing was written", path.display())]
    Write {
        /// File.
        path: PathBuf,
        /// Error of the operating system.
        cause: std::io::Error,
    },
    /// Some outputs are in place, and the next could not follow.
    #[error("{}: cannot be written: {cause}; but {} was written", path.display(), written.display())]
    Partly {
        /// File that could not be put in place.
        path: PathBuf,
        /// Error of the operating system.
        cause: std::io::Error,
        /// The last file that was put in place.
        written: PathBuf,
    },
    /// An output would replace an input.
    #[error("{}: is also an input; an input is never overwritten, choose another name for the output", path.display())]
    OverInput {
        /// File.
        path: PathBuf,
    },
    /// Two outputs have the same name.
    #[error("{}: is named twice as an output; give each output a name of its own", path.display())]
    TwiceOutput {
        /// File.
        path: PathBuf,
    },
}

/// What standard input held, once it was read.
static STANDARD_INPUT: OnceLock<Vec<u8>> = OnceLock::new();

/// What an input holds that was read before, standard input (`-`) included; `None` of a pipe, which cannot be read again.
pub fn contents(path: &Path) -> Option<Vec<u8>> {
    if is_standard(path) {
        return STANDARD_INPUT.get().cloned();
    }
    std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
    std::fs::read(path).ok()
}

/// What standard input holds; it can be read once.
fn standard_input() -> std::io::Result<Vec<u8>> {
    static READ: AtomicBool = AtomicBool::new(false);
    if READ.swap(true, Ordering::Relaxed) {
        return Err(std::io::Error::other("standard input was read already for another argument"));
    }
    let mut bytes = Vec::new();
    std::io::stdin().lock().read_to_end(&mut bytes)?;
    Ok(STANDARD_INPUT.get_or_init(|| bytes).clone())
}

/// The text of a file.
///
/// # Errors
/// [`FileError`] if it is missing, a folder, empty or not UTF-8.
pub(super) fn read_text(path: &Path) -> Result<String, FileError> {
    if path.is_dir() && !is_standard(path) {
        return Err(FileError::Folder { path: path.into() });
    }
    let bytes = if is_standard(path) { standard_input() } else { std::fs::read(path) };
    let bytes = bytes.map_err(|cause| FileError::Read { path: path.into(), cause })?;
    let text = String::from_utf8(bytes).map_err(|e| {
        let offset = e.utf8_error().valid_up_to();
        let line = 1 + e.as_bytes()[..offset].iter().filter(|b| **b == b'\n').count();
        FileError::Encoding { path: path.into(), line, offset }
    })?;
    let text = text.strip_prefix('\u{feff}').map_or(text.clone(), str::to_owned);
    if text.trim().is_empty() {
        return Err(FileError::Empty { path: path.into() });
    }
    Ok(text)
}
