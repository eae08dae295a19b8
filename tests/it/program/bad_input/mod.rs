//! Wrong files and wrong calls: the program says what is wrong, where, and what to do, and writes nothing.
//!
//! Each table has a row for each case; a test tries all rows of its table and names those that fail.

mod accepted;
mod calls;
mod measurement_files;
mod mechanism_files;
mod outputs;
mod select;

use std::fs;

use rayon::prelude::*;

use crate::common::bench::{Bench, NOISY, TABLE_5};

const CALIBRATE: &str = "calibrate m.toml d.csv -o o.toml";
const LEG_1: &str = "platform = [1299.170, -348.112, 0.0]\nbase = [1164.388, -977.037, 0.0]";
const LEG_2: &str = "platform = [1299.170, 348.112, 0.0]\nbase = [1164.388, 977.037, 0.0]";

/// A case: its name, what differs from the folder with the bundled `m.toml` and `d.csv`, the call, and what the
/// message must contain.
struct Row {
    name: &'static str,
    entries: Vec<Entry>,
    call: String,
    parts: Vec<String>,
}

/// An entry of the folder.
struct Entry(&'static str, Content);

enum Content {
    Bytes(Vec<u8>),
    Folder,
    #[cfg(unix)]
    SymbolicLink(&'static str),
    HardLink(&'static str),
}

fn row(
    name: &'static str,
    entries: impl IntoIterator<Item = Entry>,
    call: impl Into<String>,
    parts: impl IntoIterator<Item = impl Into<String>>,
) -> Row {
    let parts = parts.into_iter().map(Into::into).collect();
    Row { name, entries: entries.into_iter().collect(), call: call.into(), parts }
}

fn file(name: &'static str, content: impl AsRef<[u8]>) -> Entry {
    Entry(name, Content::Bytes(content.as_ref().to_vec()))
}

/// The usual calibration with another mechanism file.
fn mechanism(name: &'static str, text: impl AsRef<[u8]>, parts: impl IntoIterator<Item = impl Into<String>>) -> Row {
    row(name, [file("m.toml", text)], CALIBRATE, parts)
}

/// The usual calibration with another measurement file.
fn data(name: &'static str, text: impl AsRef<[u8]>, parts: impl IntoIterator<Item = impl Into<String>>) -> Row {
    row(name, [file("d.csv", text)], CALIBRATE, parts)
}

impl Row {
    /// Why the call is not refused as it should be.
    fn fails(&self) -> Option<String> {
        let bench = Bench::bundled();
        for Entry(name, content) in &self.entries {
            match content {
                Content::Bytes(bytes) => bench.write(name, bytes),
                Content::Folder => fs::create_dir(bench.at(name)).unwrap(),
                #[cfg(unix)]
                Content::SymbolicLink(to) => std::os::unix::fs::symlink(to, bench.at(name)).unwrap(),
                Content::HardLink(to) => fs::hard_link(bench.at(to), bench.at(name)).unwrap(),
            }
        }
        let parts: Vec<&str> = self.parts.iter().map(String::as_str).collect();
        bench.refusal(&self.call, &parts).err().map(|problem| format!("{}: {problem}", self.name))
    }
}

/// Tries every row, and names all that are not refused as they should be.
#[track_caller]
fn all_are_refused(rows: &[Row]) {
    let wrong: Vec<String> = rows.par_iter().filter_map(Row::fails).collect();
    assert!(wrong.is_empty(), "{} of {} cases\n{}", wrong.len(), rows.len(), wrong.join("\n"));
}

#[test]
fn a_table_names_all_rows_that_fail() {
    let rows = [
        row("accepted", [], "evaluate m.toml d.csv", ["x"]),
        row("refused", [], "evaluate m.toml no.csv", ["no.csv: cannot be read"]),
        row("other words", [], "evaluate m.toml no.csv", ["no.csv: is a poem"]),
    ];
    let wrong: Vec<Option<String>> = rows.iter().map(Row::fails).collect();
    assert!(wrong[0].as_ref().unwrap().starts_with("accepted: evaluate m.toml d.csv: exit status: 0"));
    assert!(wrong[1].is_none());
    assert!(wrong[2].as_ref().unwrap().contains("'no.csv: is a poem' is not in the message"));
}

/// The text with its first `from` replaced, which must be there.
fn replaced(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "'{from}' is not in the text");
    text.replacen(from, to, 1)
}

/// The first `rows` data rows.
fn few(rows: usize) -> String {
    NOISY.lines().take(1 + rows).map(|l| l.to_owned() + "\n").collect()
}

/// The measured poses of the data as a list of poses, cut to some rows.
fn some_poses(rows: usize) -> String {
    let pose = |line: &str| line.splitn(7, ',').last().unwrap().to_owned() + "\n";
    NOISY.lines().take(1 + rows).map(pose).collect()
}

/// `p.csv` with all measured poses.
fn poses() -> Entry {
    file("p.csv", some_poses(usize::MAX - 1))
}

fn without_tolerance() -> String {
    replaced(TABLE_5, "[tolerance]\nanchor = 0.5\nlength = 0.5\n", "")
}

/// Every leg with this stroke.
fn with_stroke(stroke: &str) -> String {
    TABLE_5.replace("length = 800.0", &format!("length = 800.0\nstroke = {stroke}"))
}
