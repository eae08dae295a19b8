//! Which sample is meant: its row in the file, or its position among the samples in use.

use std::fmt::{Display, Formatter, Result};

/// Data row of a file, from 0, header and comments not counted: what results, messages and pages name. A subset of a
/// dataset keeps the rows of its samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DataRow(pub usize);

/// Position of a sample among those that a dataset keeps, from 0: what [`Dataset::sample`](super::Dataset::sample) and
/// the lists of weights and poses of an identification count by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SamplePosition(pub usize);

impl Display for DataRow {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        self.0.fmt(f)
    }
}
