//! `paracal inspect`.
use crate::common::Ui;
use anyhow::Result;
use std::path::PathBuf;
use std::process::ExitCode;
/// Arguments of `inspect`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Mechanism file.
    mechanism: PathBuf,
}
pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    let _ = ui.machine(&args.mechanism)?;
    Ok(ExitCode::SUCCESS)
}
