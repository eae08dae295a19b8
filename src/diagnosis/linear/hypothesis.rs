//! One effect at one place.

use crate::diagnosis::linear::design_matrix::{Block, DesignMatrix};
use crate::diagnosis::linear::hypotheses::EffectColumns;
use crate::effect::ScanPoint;
use crate::measurement::DataRow;

/// An effect at a place, as the search handles it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Hypothesis {
    /// Which group of the subject.
    pub(crate) group: usize,
    /// Which place of the group.
    pub(crate) place: usize,
    /// Sample (position in the data) from which on it acts, if rows are scanned.
    pub(crate) from: Option<usize>,
}

impl Hypothesis {
    /// The place in the terms of the effect; `rows` are the data rows of the samples.
    pub(crate) fn at(&self, groups: &[EffectColumns], rows: &[DataRow]) -> ScanPoint {
        let mut at = groups[self.group].places[self.place].at.clone();
        at.row = self.from.map(|k| rows[k].0);
        at
    }

    /// Its columns in a table.
    pub(crate) fn block(&self, groups: &[EffectColumns], table: &DesignMatrix) -> Block {
        let columns = groups[self.group].places[self.place].columns.clone();
        Block { columns, first: self.from.map_or(0, |from| table.rows[from].0) }
    }
}
