//! Shared by the commands: exit codes, failures with the file that they are about, what repeats a call.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::cli::ui::Ui;
use crate::conditions::Conditions;
use crate::files::{Machine, contents};
use crate::identification::{IdentifyError, poses_from_home};
use crate::measurement::{DataRow, Dataset};
use crate::mechanism::Mechanism;
use crate::report::html;
use crate::units::Dimension;
use anyhow::anyhow;
use clap::ValueEnum;
use sha2::{Digest, Sha256};

/// The frame in which a model is taken, and in which the poses of its data are meant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Frame {
    /// That of the measurement which the model was made from.
    #[default]
    Measurement,
    /// That of the base, as in the drawing.
    Base,
}

/// Exit code of a result that must not be trusted.
const UNTRUSTED: u8 = 3;

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

/// A failed identification or evaluation with the file that it is about.
pub(crate) fn about(error: IdentifyError, machine: &Machine, path: &Path, data: &Dataset) -> anyhow::Error {
    match error {
        IdentifyError::NoTolerance => anyhow!("{}: {error}", machine.path.display()),
        IdentifyError::PriorWithoutWeights => anyhow!(error),
        IdentifyError::Sample { .. } if most_fail(machine, data) => anyhow!(
            "{}: {error}; the mechanism reaches less than half of the {} data rows, so that rather the file is read otherwise than \
             meant: check where the lengths count from (length_offset in the mechanism file), the units, the order and the signs \
             of the joints, and the dimensions and home of the mechanism; `paracal diagnose` looks for such mistakes",
            path.display(),
            data.len()
        ),
        IdentifyError::Sample { row, .. } => {
            let hint = odd_joint(machine, data, row).map_or_else(String::new, |hint| format!("; {hint}"));
            anyhow!("{}: {error}{hint}", path.display())
        }
        _ => anyhow!("{}: {error}", path.display()),
    }
}

/// True if the mechanism reaches less than half of the samples.
fn most_fail(machine: &Machine, data: &Dataset) -> bool {
    let failing = poses_from_home(machine.mechanism.as_ref(), data).iter().filter(|pose| pose.is_err()).count();
    2 * failing > data.len()
}

/// Lengths below this part of those at home look like changes from home.
const CHANGE: f64 = 0.25;

/// What is odd about the joints of a row: that they look like changes from home, or the one that is farthest from it.
fn odd_joint(machine: &Machine, data: &Dataset, row: DataRow) -> Option<String> {
    let mechanism = machine.mechanism.as_ref();
    let sample = data.iter().find(|s| s.row == row)?;
    let home = mechanism.inverse(mechanism.values(), &mechanism.home(), &Conditions::unknown()).ok()?;
    let distance = |k: &usize| (sample.joints[*k] - home[*k]).abs();
    let odd = (0..home.len()).max_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let spec = &mechanism.joints()[odd];
    let unit = machine.unit(spec.dimension);
    let shown = |v: f64| format!("{:.3} {}", unit.from_si(v), unit.name);
    let small = |k: usize| {
        mechanism.joints()[k].dimension == Dimension::Length && sample.joints[k].abs() < CHANGE * home[k].abs()
    };
    if (0..home.len()).all(small) {
        let hint = "all lengths are much shorter than at home: commanded lengths are absolute, so if these are changes from \
                    home, add the lengths at home";
        return Some(hint.into());
    }
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
        let said = match contents(path) {
            Some(bytes) => format!("{} bytes, SHA-256 {}", bytes.len(), hexadecimal(&Sha256::digest(&bytes))),
            None => "not a regular file, so not read again".into(),
        };
        settings.push((path.display().to_string(), said));
    }
    settings
}

/// SHA-256 of an input that was read, unless it was a pipe.
pub(crate) fn sha256(path: &Path) -> Option<String> {
    contents(path).map(|bytes| hexadecimal(&Sha256::digest(bytes)))
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
