//! Result of a reproduction.

use super::Comparison;
use crate::files::{CsvTable, number};
use crate::report::chart::Figure;

/// A table or figure of the paper beside ours.
#[derive(Clone, Debug, PartialEq)]
pub struct Exhibit {
    /// As it is called on the command line.
    pub name: &'static str,
    /// Title.
    pub title: &'static str,
    /// Numbers of the paper among ours.
    pub comparisons: Vec<Comparison>,
    /// Findings, one sentence each.
    pub findings: Vec<String>,
    /// Tables to keep; the first is the exhibit itself.
    pub listings: Vec<Listing>,
    /// The picture.
    pub figure: Figure,
    /// How long something took on this machine: to be told, not to be kept.
    pub took: Option<String>,
}

/// A table with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Listing {
    /// Name of the file without its ending.
    pub stem: String,
    /// The table.
    pub table: CsvTable,
}

impl Listing {
    /// An empty table with this header.
    pub(super) fn new(stem: impl Into<String>, comment: impl Into<String>, header: &[&str]) -> Self {
        let header = header.iter().map(|h| (*h).to_owned()).collect();
        Self { stem: stem.into(), table: CsvTable { comments: vec![comment.into()], header, rows: Vec::new() } }
    }

    /// Adds a row: words, then numbers; what is not a number leaves its cell empty.
    pub(super) fn row(&mut self, words: &[&str], numbers: &[f64]) {
        let words = words.iter().map(|w| (*w).to_owned());
        let cell = |v: &f64| if v.is_nan() { String::new() } else { number(*v) };
        self.table.rows.push(words.chain(numbers.iter().map(cell)).collect());
    }
}
