//! What a kind of reading states about itself.

use std::fmt::Debug;
use std::sync::Arc;

use rand::rngs::ChaCha8Rng;

use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::table::column::{Meaning, ReadingColumn};
use crate::files::table::text_table::Table;
use crate::files::table::writer::CsvTable;
use crate::identification::Estimate;
use crate::measurement::{MeasurementModel, Noise};
use crate::simulation::SimulatedSample;
use crate::units::Dimension;

/// A kind of reading: its columns, its section of the mechanism file, its simulation, and its words.
// A library without the program simulates poses alone and gives no advice.
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) trait ReadingKind: Debug + Sync {
    /// What `simulate --measure` calls it; its columns carry this name too.
    fn name(&self) -> &'static str;

    /// What was measured, with its article: `a measured pose`.
    fn noun(&self) -> &'static str;

    /// Its columns, for a file that has none of any kind.
    fn example(&self) -> &'static str;

    /// What the name of a column without its unit means to this kind, and the dimension of its numbers.
    fn column(&self, name: &str, machine: Option<&Machine>) -> Option<(ReadingColumn, Dimension)>;

    /// True for a column that makes a file one of this kind.
    fn measures(&self, meaning: &Meaning) -> bool {
        matches!(meaning, Meaning::Reading(c) if c.kind == self.name() && !c.sigma)
    }

    /// The readings of all rows, with the noise of the mechanism file where a row states none.
    ///
    /// # Errors
    /// [`FileError`] naming row, column and what to do.
    fn read(&self, table: &Table, machine: &Machine, noise: &Noise) -> Result<Readings, FileError>;

    /// Puts what was identified with the readings into its section of the file; `own` are the parameters of the model.
    fn put_identified(&self, _machine: &Machine, _own: &[Estimate], _document: &mut MechanismDocument) {}

    /// The columns that a simulated run has, with noise, in the units of the mechanism file.
    ///
    /// # Errors
    /// [`FileError::Value`] if the mechanism file lacks what is measured.
    fn simulate(
        &self,
        machine: &Machine,
        run: &[SimulatedSample],
        noise: &Noise,
        rng: &mut ChaCha8Rng,
    ) -> Result<CsvTable, FileError>;

    /// The part of the noise that its readings have, as people read it.
    fn shown_noise(&self, noise: &Noise) -> String {
        crate::units::show_length(noise.position)
    }

    /// What to do about errors as large as the mechanism.
    fn advice_on_frames(&self) -> &'static str {
        "if the data are in the tracker's own frame, `calibrate` finds it"
    }
}

/// Readings of all rows of a file.
pub(crate) struct Readings {
    /// The readings with their noise.
    pub(crate) model: Arc<dyn MeasurementModel>,
    /// True if columns state 1σ of every reading.
    pub(crate) every_sigma: bool,
}

/// 1σ in a cell; `None` if it is empty.
pub(crate) fn positive_sigma(table: &Table, row: usize, column: usize) -> Result<Option<f64>, FileError> {
    let sigma = table.number(row, column)?;
    if sigma.is_some_and(|s| s <= 0.0) {
        let advice = "must be positive; leave the cell empty if it is not known";
        return Err(table.cell_error(row, column, advice));
    }
    Ok(sigma)
}
