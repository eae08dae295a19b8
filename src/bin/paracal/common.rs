//! What the commands share: reading, warnings, progress, exit codes.

use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Result;
use indicatif::{ProgressBar, ProgressStyle};
use paracal::files::{Machine, Measurement, read_measurement};

/// Exit code of a wrong input or call.
const WRONG: u8 = 2;
/// Exit code of a result that must not be trusted.
const UNTRUSTED: u8 = 3;

/// How a command talks.
pub(crate) struct Ui {
    /// One JSON object on standard output.
    pub(crate) json: bool,
    /// No progress and no warnings.
    pub(crate) quiet: bool,
}

impl Ui {
    /// Prints the result: JSON or text.
    pub(crate) fn result(&self, text: &str, json: &serde_json::Value) {
        use std::io::Write;
        let shown = if self.json { json.to_string() } else { text.to_owned() };
        // A reader that closed the pipe (`| head`) wants no more; that is no error of ours.
        let _ = writeln!(std::io::stdout(), "{shown}");
    }

    /// Prints a warning on standard error.
    pub(crate) fn warn(&self, warning: &str) {
        if !self.quiet {
            eprintln!("warning: {warning}");
        }
    }

    /// A spinner on standard error for work that may take a while; invisible where nobody looks.
    pub(crate) fn progress(&self, message: String) -> ProgressBar {
        if self.quiet || !std::io::stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let style = ProgressStyle::with_template("{spinner} {msg} ({elapsed})")
            .unwrap_or_else(|_| ProgressStyle::default_spinner());
        let bar = ProgressBar::new_spinner().with_style(style).with_message(message);
        bar.enable_steady_tick(Duration::from_millis(200));
        bar
    }

    /// Reads a mechanism file and prints its warnings.
    pub(crate) fn machine(&self, path: &Path) -> Result<Machine> {
        let machine = Machine::read(path)?;
        machine.warnings.iter().for_each(|w| self.warn(w));
        Ok(machine)
    }

    /// Reads a measurement file and prints its warnings.
    pub(crate) fn measurement(&self, path: &Path, machine: &Machine) -> Result<Measurement> {
        let measurement = read_measurement(path, machine)?;
        measurement.warnings.iter().for_each(|w| self.warn(w));
        Ok(measurement)
    }
}

/// Exit code of a result.
pub(crate) fn verdict(trusted: bool) -> ExitCode {
    if trusted { ExitCode::SUCCESS } else { ExitCode::from(UNTRUSTED) }
}

/// Prints an error.
pub(crate) fn report_error(error: &anyhow::Error) -> ExitCode {
    eprintln!("error: {error:#}");
    ExitCode::from(WRONG)
}
