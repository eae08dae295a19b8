//! A folder in which the program runs as its users run it, and what it answers there.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

use super::hidden::cases::{Kind, Truth, draw};

/// Seed of the cases.
pub const SEED: u64 = 20;

/// The bundled mechanism and its noisy measurement.
pub const TABLE_5: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/table5.toml"));
pub const NOISY: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/data/hardpoint-noisy.csv"));

/// Names and contents of the entries of a folder; a folder in it has the content `folder`.
pub type Listing = BTreeMap<String, Vec<u8>>;

/// The arguments of a call: a line that is split at blanks, or words, which may hold blanks.
pub trait Call {
    fn words(&self) -> Vec<&str>;
}

impl Call for str {
    fn words(&self) -> Vec<&str> {
        self.split_whitespace().collect()
    }
}

impl Call for String {
    fn words(&self) -> Vec<&str> {
        self.as_str().words()
    }
}

impl Call for [&str] {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

impl<const N: usize> Call for [&str; N] {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

/// What a call printed.
pub struct Printed {
    pub out: String,
    pub err: String,
}

/// A temporary folder; calls name its files without a path.
pub struct Bench {
    folder: TempDir,
}

impl Bench {
    pub fn empty() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    /// A folder with `m.toml` and `d.csv`.
    pub fn new(mechanism: impl AsRef<[u8]>, data: impl AsRef<[u8]>) -> Self {
        Self::empty().with("m.toml", mechanism).with("d.csv", data)
    }

    /// The bundled case as `m.toml` and `d.csv`.
    pub fn bundled() -> Self {
        Self::new(TABLE_5, NOISY)
    }

    /// The bundled files where the documentation names them: `mechanisms/` and `examples/data/`.
    pub fn project() -> Self {
        let bench = Self::empty();
        for name in ["mechanisms", "examples/data", "examples/data/hangprinter", "examples/data/so-lat"] {
            fs::create_dir_all(bench.at(name)).unwrap();
            let entries = fs::read_dir(super::path(name)).unwrap().map(|entry| entry.unwrap().path());
            for from in entries.filter(|path| path.is_file()) {
                fs::copy(&from, bench.at(name).join(from.file_name().unwrap())).unwrap();
            }
        }
        bench
    }

    /// A blind case, and what is hidden in it.
    pub fn of(kind: Kind, number: usize) -> (Self, Truth) {
        let case = draw(kind, SEED, number).unwrap();
        (Self::new(&case.mechanism, &case.data), case.truth)
    }

    /// With a further file, or another one of that name.
    pub fn with(self, name: &str, content: impl AsRef<[u8]>) -> Self {
        self.write(name, content);
        self
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.at(name), content).unwrap();
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    pub fn at(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    #[track_caller]
    pub fn text(&self, name: &str) -> String {
        fs::read_to_string(self.at(name)).unwrap()
    }

    #[track_caller]
    pub fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.at(name)).unwrap()
    }

    pub fn has(&self, name: &str) -> bool {
        self.at(name).exists()
    }

    pub fn listing(&self) -> Listing {
        listing(self.path())
    }

    /// The program with these arguments, to be run in the folder.
    pub fn command(&self, call: &(impl Call + ?Sized)) -> Command {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("paracal"));
        command.current_dir(self.path()).args(call.words()).stdin(Stdio::null());
        command
    }

    pub fn run(&self, call: &(impl Call + ?Sized)) -> Output {
        self.command(call).output().unwrap()
    }

    /// What a call prints that ends with this exit code.
    #[track_caller]
    pub fn exits(&self, code: i32, call: &(impl Call + ?Sized)) -> Printed {
        let output = self.run(call);
        let [out, err] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        assert_eq!(output.status.code(), Some(code), "{:?}: {err}", call.words());
        Printed { out, err }
    }

    /// What a call prints that succeeds.
    #[track_caller]
    pub fn done(&self, call: &(impl Call + ?Sized)) -> Printed {
        self.exits(0, call)
    }

    /// The object of a call that succeeds, and its warnings.
    #[track_caller]
    pub fn json_and_warnings(&self, call: &(impl Call + ?Sized)) -> (Value, String) {
        let printed = self.done(&[&call.words()[..], &["--json"]].concat()[..]);
        (serde_json::from_str(&printed.out).unwrap(), printed.err)
    }

    #[track_caller]
    pub fn json(&self, call: &(impl Call + ?Sized)) -> Value {
        self.json_and_warnings(call).0
    }

    /// Requires that a call is refused: exit code 2 and a message with all these parts, nothing on standard output,
    /// and a folder as it was. The message.
    #[track_caller]
    pub fn refuses(&self, call: &(impl Call + ?Sized), parts: &[&str]) -> String {
        self.refusal(call, parts).unwrap_or_else(|problem| panic!("{problem}"))
    }

    /// The message of a call that is refused in that way, or what is wrong with it.
    pub fn refusal(&self, call: &(impl Call + ?Sized), parts: &[&str]) -> Result<String, String> {
        let before = self.listing();
        let output = self.run(call);
        let (call, message) = (call.words().join(" "), String::from_utf8_lossy(&output.stderr).into_owned());
        let mut problems = Vec::new();
        if output.status.code() != Some(2) {
            problems.push(format!("{}", output.status));
        }
        if !message.starts_with("error: ") {
            problems.push("no error".into());
        }
        problems
            .extend(parts.iter().filter(|p| !message.contains(**p)).map(|p| format!("'{p}' is not in the message")));
        if !output.stdout.is_empty() {
            problems.push(format!("prints {}", String::from_utf8_lossy(&output.stdout)));
        }
        let after = self.listing();
        if after != before {
            problems.push(format!("the folder has changed: {:?}", after.keys()));
        }
        if problems.is_empty() { Ok(message) } else { Err(format!("{call}: {}\n{message}", problems.join("; "))) }
    }
}

/// Names and contents of everything in a folder.
pub fn listing(folder: &Path) -> Listing {
    // A file that a running process gives its name between two looks is at neither.
    let content = |p: &Path| if p.is_dir() { Some(b"folder".to_vec()) } else { fs::read(p).ok() };
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.filter_map(|p| Some((p.file_name()?.to_str()?.to_owned(), content(&p)?))).collect()
}

#[track_caller]
pub fn says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "'{part}' is not in: {message}");
    }
}

/// The number under these keys.
#[track_caller]
pub fn number(v: &Value, keys: &[&str]) -> f64 {
    keys.iter().fold(v, |v, k| &v[*k]).as_f64().unwrap_or_else(|| panic!("no number at {keys:?} in {v}"))
}

pub fn strings(value: &Value) -> Vec<&str> {
    value.as_array().unwrap().iter().map(|v| v.as_str().unwrap()).collect()
}

pub fn verdict(found: &Value) -> &str {
    found["verdict"].as_str().unwrap()
}

pub fn names(found: &Value) -> Vec<&str> {
    found["causes"].as_array().unwrap().iter().map(|c| c["effect"].as_str().unwrap()).collect()
}

pub fn not_testable(found: &Value, effect: &str) -> String {
    let entries = found["not_testable"].as_array().unwrap();
    let entry = entries.iter().find(|e| e["effect"] == effect);
    entry.map_or(String::new(), |e| strings(&e["missing"]).join(", "))
}
