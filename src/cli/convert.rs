//! `paracal convert`.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, bail};
use serde_json::json;

use crate::cli::ui::Ui;
use crate::report::text;

/// Arguments of `convert`.
#[derive(clap::Args)]
#[command(
    after_help = "What URDF cannot express (workspace, noise, tolerance, units, length offsets) goes into a TOML file \
                  with the same stem next to it, and every command reads both.\n\
                  Example: paracal convert mechanisms/table5.toml -o hardpoints.urdf"
)]
pub(crate) struct Args {
    /// Mechanism file.
    mechanism: PathBuf,
    /// Mechanism file to write: .urdf or .toml.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    let extension = args.output.extension().map(|e| e.to_string_lossy().to_lowercase());
    if !matches!(extension.as_deref(), Some("urdf" | "toml")) {
        bail!(
            "{}: is neither a .urdf nor a .toml file; end the name of the output in one of them",
            args.output.display()
        );
    }
    let mut outputs = ui.outputs([&args.mechanism], [&args.output])?;
    let machine = ui.machine(&args.mechanism)?;
    outputs.protect(machine.inputs());
    if extension.as_deref() == Some("urdf") {
        // What cannot be URDF is refused by the name of the input.
        machine.to_urdf()?;
    }
    let written = outputs.add_mechanism(&args.output, machine.document())?;
    ui.write(outputs)?;
    written.warnings.iter().for_each(|w| ui.warn(w));
    let beside = written.side.as_ref().map_or_else(String::new, |p| format!(", with {} next to it", p.display()));
    let said = format!("{}: {}{beside}", args.output.display(), text::heading(machine.mechanism.name()));
    let warnings: Vec<&String> = machine.warnings.iter().chain(&written.warnings).collect();
    let shown = json!({
        "output": args.output, "side_file": written.side, "name": machine.mechanism.name(),
        "joints": machine.joint_names(), "warnings": warnings,
    });
    ui.result(&said, &shown)?;
    Ok(ExitCode::SUCCESS)
}
