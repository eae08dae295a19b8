//! How a command talks: results, warnings, errors, progress, and the files that it writes.

use std::cell::{Cell, RefCell};
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use crate::cli::common::Frame;
use crate::files::{Machine, Measurement, Outputs, ReadOptions, read_measurement};
use crate::measurement::Dataset;
use anstyle::{AnsiColor, Style};
use anyhow::{Context, Result, bail};
use indicatif::{ProgressBar, ProgressStyle};

/// Exit code of a wrong input or call.
const WRONG: u8 = 2;
/// A result in a sentence.
const RESULT: Style = Style::new().bold();
/// Something to mind.
const WARNING: Style = AnsiColor::Yellow.on_default().bold();
/// Something wrong.
const ERROR: Style = AnsiColor::Red.on_default().bold();

/// How a command talks. Streams of `anstream` take the colours away where nobody sees them, and under `NO_COLOR`.
pub(crate) struct Ui {
    /// One JSON object on standard output.
    pub(crate) json: bool,
    /// Suppress progress and warnings.
    pub(crate) quiet: bool,
    /// What mechanism files are read with.
    pub(crate) reading: ReadOptions,
    /// The warnings so far, for the page.
    pub(crate) warnings: RefCell<Vec<String>>,
    /// True once standard output holds a file (`-o -`); the result is then told on standard error.
    pub(crate) file_on_stdout: Cell<bool>,
}

impl Ui {
    /// Prints the result: JSON or text.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub(crate) fn result(&self, text: &str, json: &serde_json::Value) -> Result<()> {
        // The last line is the result in a sentence.
        let text = printable(text);
        let (line, end) = text.split_at(text.trim_end().len());
        let shown = match (self.json, line.rsplit_once('\n')) {
            (true, _) => json.to_string(),
            (false, Some((before, last))) => format!("{before}\n{RESULT}{last}{RESULT:#}{end}"),
            (false, None) => text,
        };
        if self.file_on_stdout.get() {
            // Whoever asks for no more than the file also wants no result.
            return if self.quiet { Ok(()) } else { Ok(written(anstream::stderr(), &shown)?) };
        }
        written(anstream::stdout(), &shown)
            .context("standard output cannot be written; files that were asked for are in place")
    }

    /// The outputs of a command that reads `inputs`. Whether they may be written is checked before any work is done for them.
    ///
    /// # Errors
    /// One of them cannot be written; or standard output is wanted for a file and for JSON.
    pub(crate) fn outputs<'p, I: AsRef<Path>>(
        &self,
        inputs: impl IntoIterator<Item = I>,
        wanted: impl IntoIterator<Item = &'p PathBuf>,
    ) -> Result<Outputs> {
        let outputs = Outputs::beside_inputs(inputs);
        for path in wanted {
            outputs.check(path)?;
            if self.json && path.as_os_str() == "-" {
                bail!("--json prints its object on standard output, so no file can be written there; name a file");
            }
        }
        Ok(outputs)
    }

    /// Writes the outputs.
    ///
    /// # Errors
    /// One of them cannot be written.
    pub(crate) fn write(&self, outputs: Outputs) -> Result<()> {
        self.file_on_stdout.set(outputs.on_standard_output());
        Ok(outputs.write()?)
    }

    /// Prints a warning on standard error.
    pub(crate) fn warn(&self, warning: &str) {
        self.warnings.borrow_mut().push(warning.to_owned());
        if !self.quiet {
            tell(WARNING, "warning", warning);
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

    /// A bar with the remaining time on standard error for work in steps; invisible where nobody looks.
    pub(crate) fn steps(&self, message: &str) -> Steps {
        let bar = self.progress(message.to_owned());
        Steps { bar }
    }

    /// Reads a mechanism file and prints its warnings.
    pub(crate) fn machine(&self, path: &Path) -> Result<Machine> {
        let machine = Machine::read_with(path, &self.reading)?;
        machine.warnings.iter().for_each(|w| self.warn(w));
        Ok(machine)
    }

    /// Reads a mechanism file and takes the model in a frame.
    pub(crate) fn machine_in(&self, path: &Path, frame: Frame) -> Result<Machine> {
        let machine = self.machine(path)?;
        match frame {
            Frame::Measurement => Ok(machine),
            Frame::Base => Ok(machine.in_base_frame()?),
        }
    }

    /// Names the columns of a measurement file that a command without a search for causes does not read.
    pub(crate) fn not_used(&self, measurement: &Measurement) {
        let names = &measurement.columns_not_used;
        if !names.is_empty() {
            let columns = if names.len() == 1 { "column" } else { "columns" };
            let names = names.join(", ");
            self.warn(&format!(
                "the model reads nothing in the {columns} {names}; `diagnose` takes numbers there for conditions"
            ));
        }
    }

    /// Reads a measurement file and prints its warnings.
    pub(crate) fn measurement(&self, path: &Path, machine: &Machine) -> Result<Measurement> {
        let measurement = read_measurement(path, machine)?;
        measurement.warnings.iter().for_each(|w| self.warn(w));
        Ok(measurement)
    }
}

impl Ui {
    /// Lets a machine take the references that its file does not state from data, and says so.
    pub(crate) fn refer(&self, machine: &mut Machine, data: &Dataset, path: &Path) {
        let states = data.iter().map(|s| &s.conditions);
        machine.refer_to(states, &path.display().to_string()).iter().for_each(|w| self.warn(w));
    }
}

/// Progress of work in steps.
pub(crate) struct Steps {
    bar: ProgressBar,
}

impl Steps {
    /// What is being done now.
    pub(crate) fn say(&self, message: &str) {
        self.bar.set_message(message.to_owned());
        self.bar.set_length(0);
        self.bar.set_position(0);
        self.bar.reset_eta();
    }

    /// How many steps of how many are done.
    pub(crate) fn set(&self, done: usize, total: usize) {
        let bar = &self.bar;
        if bar.length() != Some(total as u64) {
            let style = ProgressStyle::with_template("{spinner} {msg} [{bar:30}] {pos}/{len} ({elapsed}, {eta} left)");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.set_length(total as u64);
        }
        bar.set_position(done as u64 + 1);
    }

    /// Progress of work in several parts.
    pub(crate) fn work(&self, message: &str, done: usize, total: usize) {
        if self.bar.message() != message {
            self.say(message);
        }
        if total > 0 {
            self.set(done.saturating_sub(1), total);
        }
    }

    /// Clears the line.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Prints an error; for scripts also as an object.
pub(crate) fn report_error(error: &anyhow::Error, json: bool) -> ExitCode {
    tell(ERROR, "error", &format!("{error:#}"));
    if json {
        let object = serde_json::json!({ "error": format!("{error:#}"), "exit": WRONG });
        // There is nobody left to tell that even this cannot be written.
        let _ = written(anstream::stdout(), &object.to_string());
    }
    ExitCode::from(WRONG)
}

/// A line on standard error, without colours where nobody sees them; a reader that closed it wants none.
fn tell(style: Style, word: &str, line: &str) {
    let _ = written(anstream::stderr(), &format!("{style}{word}:{style:#} {}", printable(line)));
}

/// Writes a line. A reader that closed the pipe (`| head`) wants no more; that is no error of ours.
fn written(mut to: impl Write, line: &str) -> std::io::Result<()> {
    match writeln!(to, "{line}").and_then(|()| to.flush()) {
        Err(cause) if cause.kind() == ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

/// A text for a terminal: what came from files is not to move its cursor or change its colours.
fn printable(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\n' => shown.push(c),
            c if c.is_control() => shown.extend(c.escape_default()),
            c => shown.push(c),
        }
    }
    shown
}
