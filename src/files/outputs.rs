//! Output files appear whole or not at all.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use crate::files::error::FileError;

/// Files that are to appear together.
///
/// Each is written under a temporary name in its own folder; only when all are on the disk are they renamed.
/// What is not a regular file (`-`, which is standard output, or a pipe) is written directly, after the others are staged.
///
/// Temporary files are called `.paracal-….part`. A run that is killed may leave one behind; whoever writes into that
/// folder an hour later removes it.
#[derive(Debug, Default)]
pub struct Outputs {
    files: Vec<(PathBuf, Vec<u8>)>,
    inputs: Vec<PathBuf>,
}

impl Outputs {
    /// Outputs of a command that reads `inputs`; none of these is ever written.
    pub fn beside_inputs<P: AsRef<Path>>(inputs: impl IntoIterator<Item = P>) -> Self {
        Self { files: Vec::new(), inputs: inputs.into_iter().map(|p| p.as_ref().into()).collect() }
    }

    /// Adds inputs, once it is known which files were read.
    pub fn protect<P: AsRef<Path>>(&mut self, inputs: impl IntoIterator<Item = P>) {
        self.inputs.extend(inputs.into_iter().map(|p| p.as_ref().into()));
    }

    /// True if one of the files is standard output.
    pub fn on_standard_output(&self) -> bool {
        self.files.iter().any(|(path, _)| is_standard(path))
    }

    /// Checks that `path` may be written, before any work is done for it.
    ///
    /// # Errors
    /// [`FileError::OverInput`], [`FileError::Folder`], or [`FileError::Write`] if its folder does not exist.
    pub fn check(&self, path: &Path) -> Result<(), FileError> {
        if is_standard(path) {
            return Ok(());
        }
        if path.is_dir() {
            return Err(FileError::Folder { path: path.into() });
        }
        if self.inputs.iter().any(|input| same_file(input, path)) {
            return Err(FileError::OverInput { path: path.into() });
        }
        let folder = folder_of(path);
        match fs::metadata(folder) {
            Ok(meta) if meta.is_dir() => Ok(()),
            Ok(_) => {
                let problem = format!("'{}' is a file, not a folder", folder.display());
                Err(write_error(path, std::io::Error::other(problem)))
            }
            Err(cause) => {
                let problem = format!("folder '{}': {cause}, create it or name another", folder.display());
                Err(write_error(path, std::io::Error::new(cause.kind(), problem)))
            }
        }
    }

    /// Adds a file.
    ///
    /// # Errors
    /// As [`check`](Self::check), and [`FileError::TwiceOutput`].
    pub fn add(&mut self, path: &Path, text: impl Into<Vec<u8>>) -> Result<(), FileError> {
        self.check(path)?;
        if self.files.iter().any(|(other, _)| same_file(other, path)) {
            return Err(FileError::TwiceOutput { path: path.into() });
        }
        self.files.push((path.into(), text.into()));
        Ok(())
    }

    /// Writes all files, or none.
    ///
    /// # Errors
    /// [`FileError::Write`]; temporary files are removed. [`FileError::Partly`] if the system puts one file in
    /// place and refuses the next.
    pub fn write(self) -> Result<(), FileError> {
        let mut staged: Vec<(PathBuf, PathBuf)> = Vec::new();
        let result = self.stage(&mut staged);
        if result.is_err() {
            for (temporary, _) in &staged {
                // It may not have come into being; there is nothing to do about it either way.
                let _ = fs::remove_file(temporary);
            }
            return result;
        }
        for (k, (temporary, path)) in staged.iter().enumerate() {
            if let Err(cause) = fs::rename(temporary, path) {
                for (left, _) in &staged[k..] {
                    let _ = fs::remove_file(left);
                }
                return Err(match staged[..k].last() {
                    Some((_, written)) => FileError::Partly { path: path.clone(), cause, written: written.clone() },
                    None => write_error(path, cause),
                });
            }
        }
        Ok(())
    }

    fn stage(&self, staged: &mut Vec<(PathBuf, PathBuf)>) -> Result<(), FileError> {
        let regular = |path: &Path| !is_standard(path) && fs::metadata(path).map_or(true, |m| m.is_file());
        let mut folders = BTreeSet::new();
        for (path, bytes) in self.files.iter().filter(|(p, _)| regular(p)) {
            // A link is followed, so that the file behind it is replaced and not the link.
            let path = fs::canonicalize(path).unwrap_or_else(|_| path.clone());
            if folders.insert(folder_of(&path).to_path_buf()) {
                remove_abandoned(folder_of(&path));
            }
            let written = temporary_in(folder_of(&path)).and_then(|(temporary, mut f)| {
                staged.push((temporary, path.clone()));
                f.write_all(bytes)?;
                // A file that is replaced keeps its mode.
                if let Ok(old) = fs::metadata(&path) {
                    f.set_permissions(old.permissions())?;
                }
                f.sync_all()
            });
            written.map_err(|cause| write_error(&path, cause))?;
        }
        for (path, bytes) in self.files.iter().filter(|(p, _)| !regular(p)) {
            let put = |to: &mut dyn Write| to.write_all(bytes).and_then(|()| to.flush());
            let written = match is_standard(path) {
                true => put(&mut std::io::stdout().lock()),
                false => OpenOptions::new().write(true).open(path).and_then(|mut f| put(&mut f)),
            };
            written.map_err(|cause| write_error(path, cause))?;
        }
        Ok(())
    }
}

/// True for `-`, which names standard input where a file is read and standard output where one is written.
pub(crate) fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// How the name of a temporary file begins and ends.
const TEMPORARY: [&str; 2] = [".paracal-", ".part"];
/// A temporary file lives for the time of a write; one of this age is that of a run that was killed.
const ABANDONED: Duration = Duration::from_secs(3600);

/// A new temporary file. Its number of the process need not be its own: another machine, or another container, may write
/// into the same folder.
fn temporary_in(folder: &Path) -> std::io::Result<(PathBuf, File)> {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let [begin, end] = TEMPORARY;
    loop {
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = folder.join(format!("{begin}{}-{count}{end}", std::process::id()));
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Err(cause) if cause.kind() == ErrorKind::AlreadyExists => {}
            other => return other.map(|file| (path, file)),
        }
    }
}

/// Removes what killed runs left behind. A folder that does not let itself be tidied up may still be written to.
fn remove_abandoned(folder: &Path) {
    let [begin, end] = TEMPORARY;
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let ours = name.to_str().is_some_and(|n| n.starts_with(begin) && n.ends_with(end));
        let age = || entry.metadata().ok()?.modified().ok()?.elapsed().ok();
        if ours && age().is_some_and(|age| age > ABANDONED) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn write_error(path: &Path, cause: std::io::Error) -> FileError {
    FileError::Write { path: path.into(), cause }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."))
}

fn same_file(a: &Path, b: &Path) -> bool {
    if a == b {
        return true;
    }
    match (resolved(a), resolved(b)) {
        (Some(a), Some(b)) => a == b || same_inode(&a, &b),
        _ => false,
    }
}

/// The path without links and detours; the file itself need not exist.
fn resolved(path: &Path) -> Option<PathBuf> {
    let of_new_file = || Some(fs::canonicalize(folder_of(path)).ok()?.join(path.file_name()?));
    fs::canonicalize(path).ok().or_else(of_new_file)
}

#[cfg(unix)]
fn same_inode(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (fs::metadata(a), fs::metadata(b)) {
        (Ok(a), Ok(b)) => a.dev() == b.dev() && a.ino() == b.ino(),
        _ => false,
    }
}

#[cfg(not(unix))]
fn same_inode(_: &Path, _: &Path) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let (good, missing) = (folder.path().join("a.txt"), folder.path().join("no/such/b.txt"));
        let mut outputs = Outputs::default();
        outputs.add(&good, "text").unwrap();
        assert!(matches!(outputs.add(&missing, "text"), Err(FileError::Write { .. })));
        outputs.files.push((missing, b"text".to_vec()));
        assert!(outputs.write().is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn names_of_temporary_files_never_meet() {
        // Another container may have the same number of a process, and many threads of one process may write at once.
        let folder = tempfile::tempdir().unwrap();
        let taken: Vec<PathBuf> = (0..2000)
            .map(|count| folder.path().join(format!(".paracal-{}-{count}.part", std::process::id())))
            .collect();
        taken.iter().for_each(|path| fs::write(path, "another's").unwrap());
        std::thread::scope(|scope| {
            for thread in 0..8 {
                let path = folder.path().join(format!("{thread}.txt"));
                scope.spawn(move || {
                    for _ in 0..20 {
                        let mut outputs = Outputs::default();
                        outputs.add(&path, format!("{thread}").repeat(10_000)).unwrap();
                        outputs.write().unwrap();
                    }
                });
            }
        });
        for thread in 0..8 {
            let text = fs::read_to_string(folder.path().join(format!("{thread}.txt"))).unwrap();
            assert!(text == format!("{thread}").repeat(10_000), "{thread}");
        }
        assert!(taken.iter().all(|path| fs::read(path).unwrap() == b"another's"));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2008);
    }

    #[test]
    fn what_killed_runs_left_is_removed_when_it_is_old() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, age: u64| {
            let path = folder.path().join(name);
            let file = File::create(&path).unwrap();
            file.set_modified(std::time::SystemTime::now() - Duration::from_secs(age)).unwrap();
            path
        };
        let old = file(".paracal-1-0.part", 3700);
        let kept = [file(".paracal-1-1.part", 100), file(".paracal-notes.txt", 9999), file("x.part", 9999)];
        let mut outputs = Outputs::default();
        outputs.add(&folder.path().join("new.txt"), "text").unwrap();
        outputs.write().unwrap();
        assert!(!old.exists() && kept.iter().all(|path| path.exists()));
    }

    #[test]
    fn one_file_by_two_paths_is_one_output() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("sub")).unwrap();
        let mut outputs = Outputs::default();
        outputs.add(&folder.path().join("new.txt"), "a").unwrap();
        let detour = folder.path().join("sub/../new.txt");
        assert!(matches!(outputs.add(&detour, "b"), Err(FileError::TwiceOutput { .. })));
    }

    #[test]
    fn inputs_are_never_written_even_through_links() {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("in.toml");
        fs::write(&input, "x").unwrap();
        let link = folder.path().join("link.toml");
        fs::hard_link(&input, &link).unwrap();
        let outputs = Outputs::beside_inputs([&input]);
        assert!(matches!(outputs.check(&input), Err(FileError::OverInput { .. })));
        assert!(matches!(outputs.check(&link), Err(FileError::OverInput { .. })));
    }
}
