//! Long work in units that survive a stop.

use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use thiserror::Error;

/// A journal that cannot be kept.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum JournalError {
    /// The file cannot be read or written.
    #[error("{path}: {cause}; the journal of finished work must be a file that can be read and written")]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        cause: std::io::Error,
    },
    /// The file is something else, and is left alone.
    #[error("{path} is not a journal of finished work; move it away, or work in another folder")]
    Foreign {
        /// The file.
        path: PathBuf,
    },
}

/// Finished units of work, one line each, by a key that says everything the result depends on.
///
/// A unit that is in the journal is read and not done again; what is read has the same bits as what was computed. A unit
/// that was cut off in the middle of its line is done again, and so is everything if the journal is that of another
/// version of the program. Lines are appended whole, so that two programs may keep one journal.
#[derive(Debug)]
pub struct Journal {
    finished: Mutex<HashMap<String, Value>>,
    file: Option<(PathBuf, Mutex<File>)>,
}

#[derive(Serialize, Deserialize)]
struct Line {
    unit: String,
    result: Value,
}

/// The first line: results of another version of the program are not taken over.
const HEADING: &str = concat!("paracal journal of finished units, version ", env!("CARGO_PKG_VERSION"), "\n");
/// How the first line of any version begins.
const ANY_HEADING: &str = "paracal journal of finished units, version ";

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Whoever panicked while it was held left a map or a file that is whole.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Journal {
    /// A journal that ends with the program.
    pub fn in_memory() -> Self {
        Self { finished: Mutex::default(), file: None }
    }

    /// The journal in a file, which is created if there is none.
    ///
    /// # Errors
    /// [`JournalError`] if the file cannot be read or written.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, JournalError> {
        let path = path.as_ref().to_owned();
        let about = |cause: std::io::Error| JournalError::File { path: path.clone(), cause };
        // A pipe has no end to read to.
        if std::fs::metadata(&path).is_ok_and(|m| !m.is_file()) {
            return Err(JournalError::Foreign { path });
        }
        let mut bytes = Vec::new();
        let mut file = OpenOptions::new().read(true).append(true).create(true).open(&path).map_err(about)?;
        file.read_to_end(&mut bytes).map_err(about)?;
        let text = String::from_utf8_lossy(&bytes);
        let mut finished = HashMap::new();
        if let Some(lines) = text.strip_prefix(HEADING) {
            let whole = lines.lines().filter_map(|line| serde_json::from_str::<Line>(line).ok());
            finished.extend(whole.map(|line| (line.unit, line.result)));
            // A line that was cut off is closed, so that the next begins on its own.
            if !text.ends_with('\n') {
                file.write_all(b"\n").map_err(about)?;
            }
        } else if text.is_empty() {
            // Another program may begin the same journal now: nothing is cut off, and a second heading is passed over.
            file.write_all(HEADING.as_bytes()).map_err(about)?;
        } else if text.starts_with(ANY_HEADING) || ANY_HEADING.starts_with(&*text) {
            file.set_len(0).and_then(|()| file.write_all(HEADING.as_bytes())).map_err(about)?;
        } else {
            return Err(JournalError::Foreign { path });
        }
        Ok(Self { finished: Mutex::new(finished), file: Some((path, Mutex::new(file))) })
    }

    /// How many units are finished.
    pub fn len(&self) -> usize {
        locked(&self.finished).len()
    }

    /// True if no unit is finished.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The result of a unit: from the journal, or from `work`, whose result is added.
    ///
    /// # Errors
    /// Those of `work`, which are not kept, and [`JournalError`] if the file cannot be written.
    pub fn unit<T: Serialize + DeserializeOwned, E: From<JournalError>>(
        &self,
        key: &str,
        work: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        let known = locked(&self.finished).get(key).cloned();
        // What cannot be read as such a result, NaN among it, is computed again.
        if let Some(result) = known.and_then(|value| serde_json::from_value(value).ok()) {
            return Ok(result);
        }
        let result = work()?;
        let Ok(value) = serde_json::to_value(&result) else { return Ok(result) };
        if let Some((path, file)) = &self.file {
            let about = |cause: std::io::Error| JournalError::File { path: path.clone(), cause };
            let line = Line { unit: key.to_owned(), result: value.clone() };
            let mut text = serde_json::to_string(&line).map_err(|e| about(e.into()))?;
            text.push('\n');
            locked(file).write_all(text.as_bytes()).map_err(about)?;
        }
        locked(&self.finished).insert(key.to_owned(), value);
        Ok(result)
    }

    /// Removes the file, when everything that it was kept for is done.
    ///
    /// # Errors
    /// [`JournalError`] if it cannot be removed.
    pub fn remove(self) -> Result<(), JournalError> {
        let Some((path, file)) = self.file else { return Ok(()) };
        drop(file);
        match std::fs::remove_file(&path) {
            // Another program kept it too, and was done first.
            Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => Err(JournalError::File { path, cause }),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(k: u32) -> Vec<f64> {
        (1..50).map(|j| f64::from(k + 1).sqrt() / f64::from(j).powi(9)).collect()
    }

    fn fill(path: &Path, units: u32) -> (Vec<Vec<f64>>, usize) {
        let journal = Journal::open(path).unwrap();
        let mut done = 0;
        let results = (0..units).map(|k| {
            journal
                .unit(&format!("unit {k}"), || -> Result<_, JournalError> {
                    done += 1;
                    Ok(value(k))
                })
                .unwrap()
        });
        (results.collect(), done)
    }

    #[test]
    fn a_journal_cut_off_anywhere_goes_on_to_the_same_bits() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal");
        let (whole, done) = fill(&path, 6);
        assert_eq!(done, 6);
        let bytes = std::fs::read(&path).unwrap();
        for cut in (0..=bytes.len()).step_by(97) {
            std::fs::write(&path, &bytes[..cut]).unwrap();
            let (again, repeated) = fill(&path, 6);
            assert_eq!(again, whole, "cut at {cut}");
            let lines = bytes[..cut].iter().filter(|b| **b == b'\n').count().saturating_sub(1);
            assert!(repeated >= 6 - lines - 1 && repeated <= 6 - lines, "cut at {cut}: {repeated} repeated");
            // And what was added after the cut can be read again.
            assert_eq!(fill(&path, 6), (whole.clone(), 0), "cut at {cut}");
        }
        Journal::open(&path).unwrap().remove().unwrap();
        assert!(!path.exists());
    }

    #[test]
    fn a_journal_of_another_version_is_begun_anew() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal");
        std::fs::write(&path, format!("{ANY_HEADING}0.0.0\n{{\"unit\":\"a\",\"result\":1.0}}\n")).unwrap();
        let journal = Journal::open(&path).unwrap();
        assert!(journal.is_empty());
        assert_eq!(journal.unit("a", || Ok::<_, JournalError>(2.0)).unwrap(), 2.0);
        // What is no journal is left alone.
        assert!(matches!(Journal::open(folder.path()), Err(JournalError::Foreign { .. })));
        for foreign in [&b"my notes\n"[..], &[0xff, 0, 1]] {
            std::fs::write(&path, foreign).unwrap();
            assert!(matches!(Journal::open(&path), Err(JournalError::Foreign { .. })));
            assert_eq!(std::fs::read(&path).unwrap(), foreign);
        }
    }
}
