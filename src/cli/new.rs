//! `paracal new`.

use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::builder::{PossibleValue, PossibleValuesParser};
use serde_json::json;

use crate::cli::common::Ui;
use crate::files::{ExampleFile, example_files};

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
    if ui.json {
        let ExampleFile { kind, label, text } = example;
        ui.result("", &json!({ "type": kind, "label": label, "text": text }));
    } else {
        use std::io::Write;
        // A reader that closed the pipe wants no more.
        let _ = std::io::stdout().write_all(example.text.as_bytes());
    }
    Ok(ExitCode::SUCCESS)
}

/// A line for each kind.
fn list() -> String {
    let width = example_files().map(|example| example.kind.len()).max().unwrap_or(0);
    let lines: Vec<String> = example_files().map(|e| format!("  {:width$}  {}", e.kind, e.label)).collect();
    lines.join("\n")
}
