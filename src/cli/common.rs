//! Shared by the commands: reading, warnings, progress, exit codes.

use std::cell::RefCell;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use crate::conditions::Conditions;
use crate::files::{Machine, Measurement, ReadOptions, read_measurement};
use crate::identification::IdentifyError;
use crate::measurement::{DataRow, Dataset};
use crate::mechanism::Mechanism;
use crate::report::html;
use crate::units::Dimension;
use anstyle::{AnsiColor, Style};
use anyhow::{Result, anyhow};
use indicatif::{ProgressBar, ProgressStyle};
use sha2::{Digest, Sha256};

/// Exit code of a wrong input or call.
const WRONG: u8 = 2;
/// Exit code of a result that must not be trusted.
const UNTRUSTED: u8 = 3;

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
}

impl Ui {
    /// Prints the result: JSON or text.
    pub(crate) fn result(&self, text: &str, json: &serde_json::Value) {
        use std::io::Write;
        // The last line is the result in a sentence.
        let (line, end) = text.split_at(text.trim_end().len());
        let shown = match (self.json, line.rsplit_once('\n')) {
            (true, _) => json.to_string(),
            (false, Some((before, last))) => format!("{before}\n{RESULT}{last}{RESULT:#}{end}"),
            (false, None) => text.to_owned(),
        };
        // A reader that closed the pipe (`| head`) wants no more; that is no error of ours.
        let _ = writeln!(anstream::stdout(), "{shown}");
    }

    /// Prints a warning on standard error.
    pub(crate) fn warn(&self, warning: &str) {
        self.warnings.borrow_mut().push(warning.to_owned());
        if !self.quiet {
            tell(&format!("{WARNING}warning:{WARNING:#} {warning}"));
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

/// What the joints of a mechanism are called: lengths, angles, or coordinates if they are of several kinds.
pub(crate) fn joint_noun(mechanism: &dyn Mechanism) -> &'static str {
    let mut nouns = mechanism.joints().iter().map(|j| j.dimension.noun());
    let first = nouns.next().unwrap_or(Dimension::None.noun());
    if nouns.all(|n| n == first) { first } else { Dimension::None.noun() }
}

/// Exit code of a result.
pub(crate) fn verdict(trusted: bool) -> ExitCode {
    if trusted { ExitCode::SUCCESS } else { ExitCode::from(UNTRUSTED) }
}

/// Prints an error.
pub(crate) fn report_error(error: &anyhow::Error) -> ExitCode {
    tell(&format!("{ERROR}error:{ERROR:#} {error:#}"));
    ExitCode::from(WRONG)
}

/// A line on standard error, without colours where nobody sees them; a reader that closed it wants none.
fn tell(line: &str) {
    use std::io::Write;
    let _ = writeln!(anstream::stderr(), "{line}");
}

/// A failed identification or evaluation with the file that it is about.
pub(crate) fn about(error: IdentifyError, machine: &Machine, path: &Path, data: &Dataset) -> anyhow::Error {
    match error {
        IdentifyError::NoTolerance => anyhow!("{}: {error}", machine.path.display()),
        IdentifyError::PriorWithoutWeights => anyhow!(error),
        IdentifyError::Sample { row, .. } => {
            let hint = odd_joint(machine, data, row).map_or_else(String::new, |hint| format!("; {hint}"));
            anyhow!("{}: {error}{hint}", path.display())
        }
        _ => anyhow!("{}: {error}", path.display()),
    }
}

/// The joint of a row that is farthest from its place at home.
fn odd_joint(machine: &Machine, data: &Dataset, row: DataRow) -> Option<String> {
    let mechanism = machine.mechanism.as_ref();
    let sample = data.iter().find(|s| s.row == row)?;
    let home = mechanism.inverse(mechanism.values(), &mechanism.home(), &Conditions::unknown()).ok()?;
    let distance = |k: &usize| (sample.joints[*k] - home[*k]).abs();
    let odd = (0..home.len()).max_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let spec = &mechanism.joints()[odd];
    let unit = machine.unit(spec.dimension);
    let shown = |v: f64| format!("{:.3} {}", unit.from_si(v), unit.name);
    Some(format!(
        "{} is farthest from home at {} (home {}): correct or delete the row, or check the mechanism file",
        spec.name,
        shown(sample.joints[odd]),
        shown(home[odd])
    ))
}

/// What repeats a command, for its report: the call, the seed, and the inputs with their sizes and SHA-256.
pub(crate) fn settings<P: AsRef<Path>>(
    seed: Option<u64>,
    inputs: impl IntoIterator<Item = P>,
) -> Vec<(String, String)> {
    let call: Vec<String> = std::env::args_os().skip(1).map(|word| quoted(&word.to_string_lossy())).collect();
    let mut settings = vec![("call".to_owned(), format!("paracal {}", call.join(" ")))];
    settings.extend(seed.map(|seed| ("seed".to_owned(), seed.to_string())));
    let mut seen: Vec<PathBuf> = Vec::new();
    for input in inputs {
        let path = input.as_ref();
        if seen.iter().any(|other| other == path) {
            continue;
        }
        seen.push(path.into());
        // A pipe was read already and cannot be read again.
        let said = match std::fs::metadata(path)
            .ok()
            .filter(std::fs::Metadata::is_file)
            .and_then(|_| std::fs::read(path).ok())
        {
            Some(bytes) => format!("{} bytes, SHA-256 {}", bytes.len(), hexadecimal(&Sha256::digest(&bytes))),
            None => "not a regular file, so not read again".into(),
        };
        settings.push((path.display().to_string(), said));
    }
    settings
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

/// A word as a shell reads it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_=.,/:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// What a page says of the mechanism.
pub(crate) fn page_subject<'a>(
    ui: &Ui,
    machine: &'a Machine,
    mechanism: &'a dyn Mechanism,
    settings: Vec<(String, String)>,
) -> html::Subject<'a> {
    // Noise of the joints makes errors of a size that differs from pose to pose.
    let noise = machine.noise.as_ref().filter(|n| n.joint == 0.0).map(|n| [n.position, n.rotation]);
    let warnings = ui.warnings.borrow().clone();
    let (convention, condition_kinds) = (&machine.convention, machine.condition_kinds());
    let frames = html::frames_of(mechanism, machine.commander());
    html::Subject { mechanism, frames, convention, condition_kinds, noise, warnings, settings }
}
