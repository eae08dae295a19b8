//! `paracal new`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::builder::{PossibleValue, PossibleValuesParser};
use serde_json::json;

use crate::cli::ui::Ui;
use crate::files::{ExampleFile, Outputs, example_files};

/// Arguments of `new`.
#[derive(clap::Args)]
#[command(
    after_help = "The file is accepted as it stands: `inspect` shows what the program makes of it. Replace its numbers by \
                        your own.\n\
                        Example: paracal new six-hardpoint > hexapod.toml"
)]
pub(crate) struct Args {
    /// The kind of mechanism; without it the kinds are listed.
    #[arg(value_parser = kinds())]
    kind: Option<String>,
    /// File to write instead of standard output; it must not exist yet.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// The kinds of which there is an example.
fn kinds() -> PossibleValuesParser {
    PossibleValuesParser::new(example_files().map(|example| PossibleValue::new(example.kind).help(example.label)))
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    let Some(example) = args.kind.as_deref().and_then(|kind| example_files().find(|e| e.kind == kind)) else {
        // An error, lest the list end in a file that is meant to be a mechanism.
        bail!("name the kind of mechanism, as in `paracal new six-hardpoint > hexapod.toml`:\n{}", list());
    };
    let ExampleFile { kind, label, text, .. } = example;
    match &args.output {
        Some(path) => {
            save(text, path)?;
            let shown = path.display().to_string();
            let said = format!("{shown} written: {label}; put in your own numbers, then: paracal inspect {shown}");
            ui.result(&said, &json!({ "type": kind, "label": label, "output": shown }))?;
        }
        None if ui.json => ui.result("", &json!({ "type": kind, "label": label, "text": text }))?,
        None => {
            use std::io::Write;
            // A reader that closed the pipe wants no more.
            let _ = std::io::stdout().write_all(text.as_bytes());
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Writes a new file; one that exists has numbers of its user.
fn save(text: &str, path: &Path) -> Result<()> {
    if path.exists() {
        bail!("{}: exists already; choose another name, or delete it first", path.display());
    }
    let mut outputs = Outputs::beside_inputs::<&Path>([]);
    outputs.add(path, text)?;
    Ok(outputs.write()?)
}

/// A line for each kind.
fn list() -> String {
    let width = example_files().map(|example| example.kind.len()).max().unwrap_or(0);
    let lines: Vec<String> = example_files().map(|e| format!("  {:width$}  {}", e.kind, e.label)).collect();
    lines.join("\n")
}
