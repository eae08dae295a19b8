//! A folder with a mechanism file and a measurement file in which the program runs, and what it answers.

use std::path::Path;
use std::process::Output;

use serde_json::Value;
use tempfile::TempDir;

use super::hidden::cases::{Kind, Truth, draw};

/// Seed of the cases.
pub const SEED: u64 = 20;

/// A folder with `m.toml` and `d.csv`.
pub struct Bench {
    folder: TempDir,
}

impl Bench {
    pub fn new(mechanism: &str, data: &str) -> Self {
        let bench = Self { folder: tempfile::tempdir().unwrap() };
        bench.file("m.toml", mechanism);
        bench.file("d.csv", data);
        bench
    }

    /// A blind case, and what is hidden in it.
    pub fn of(kind: Kind, number: usize) -> (Self, Truth) {
        let case = draw(kind, SEED, number).unwrap();
        (Self::new(&case.mechanism, &case.data), case.truth)
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    pub fn file(&self, name: &str, text: &str) {
        std::fs::write(self.path().join(name), text).unwrap();
    }

    pub fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.path().join(name)).unwrap()
    }

    pub fn has(&self, name: &str) -> bool {
        self.path().join(name).exists()
    }

    pub fn run(&self, call: &str) -> Output {
        let words = call.split_whitespace();
        assert_cmd::cargo::cargo_bin_cmd!("paracal").current_dir(self.path()).args(words).output().unwrap()
    }

    /// Standard output of a call with this exit code.
    #[track_caller]
    pub fn exits(&self, code: i32, call: &str) -> String {
        let output = self.run(call);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{call}: {message}");
        String::from_utf8(output.stdout).unwrap()
    }

    #[track_caller]
    pub fn json(&self, call: &str) -> Value {
        serde_json::from_str(&self.exits(0, &format!("{call} --json"))).unwrap()
    }

    /// The message of a call that is refused: exit code 2, nothing on standard output.
    #[track_caller]
    pub fn refused(&self, call: &str, parts: &[&str]) {
        let output = self.run(call);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{call}: {message}{}", String::from_utf8_lossy(&output.stdout));
        assert!(message.starts_with("error: ") && output.stdout.is_empty(), "{call}: {message}");
        for part in parts {
            assert!(message.contains(part), "{call}: '{part}' is not in: {message}");
        }
    }
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
