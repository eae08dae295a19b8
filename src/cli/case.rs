//! Input of `diagnose` and `settle`: a machine and data.

use std::path::PathBuf;

use crate::diagnosis::{DiagnoseError, Question};
use crate::files::{Machine, Measurement, Outputs};
use anyhow::{Result, bail};

use crate::cli::common::about;
use crate::cli::ui::Ui;

/// The two files, and how their noise is meant.
#[derive(clap::Args)]
pub(crate) struct CaseArgs {
    /// Mechanism file; the effects in it are searched for afresh.
    pub(crate) mechanism: PathBuf,
    /// Measurement file with the conditions of each row: temperatures, elevation, payload, time.
    pub(crate) data: PathBuf,
    /// Take the stated noise as known; otherwise its size is estimated and only the ratio of position to rotation is
    /// used.
    #[arg(long)]
    noise_known: bool,
}

/// The files, read.
pub(crate) struct Case<'a> {
    args: &'a CaseArgs,
    pub(crate) machine: Machine,
    pub(crate) measurement: Measurement,
}

impl CaseArgs {
    /// Reads the files; `written` is what will be written beside them.
    pub(crate) fn read(&self, written: &[Option<&PathBuf>], ui: &Ui) -> Result<(Case<'_>, Outputs)> {
        let mut outputs = ui.outputs([&self.mechanism, &self.data], written.iter().copied().flatten())?;
        let machine = ui.machine(&self.mechanism)?.without_effects()?;
        outputs.protect(machine.inputs());
        let measurement = ui.measurement(&self.data, &machine)?;
        if self.noise_known && !measurement.data.noise.known {
            bail!("--noise-known: {} states no [noise], and the data have no sigma columns", self.mechanism.display());
        }
        Ok((Case { args: self, machine, measurement }, outputs))
    }
}

impl Case<'_> {
    /// What is asked of the data.
    pub(crate) fn question(&self) -> Question<'_> {
        Question { noise_known: self.args.noise_known, ..Question::of(&self.machine, &self.measurement.data) }
    }

    /// A failed diagnosis with the file that it is about.
    pub(crate) fn about(&self, error: DiagnoseError) -> anyhow::Error {
        let data = &self.args.data;
        match error {
            DiagnoseError::Identify(cause) => about(cause, &self.machine, data, &self.measurement.data),
            other => anyhow::Error::new(other).context(data.display().to_string()),
        }
    }
}
