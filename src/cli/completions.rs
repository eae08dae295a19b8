//! `paracal completions`.

use std::process::ExitCode;

use anyhow::Result;
use clap_complete::Shell;

/// Arguments of `completions`.
#[derive(clap::Args)]
#[command(after_help = "Example: paracal completions bash > ~/.local/share/bash-completion/completions/paracal")]
pub(crate) struct Args {
    /// The shell that completes.
    shell: Shell,
}

/// Prints what the shell reads; `command` is the whole program.
pub(crate) fn run(args: &Args, mut command: clap::Command) -> Result<ExitCode> {
    use std::io::Write;
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "paracal", &mut script);
    // A reader that closed the pipe wants no more.
    let _ = std::io::stdout().write_all(&script);
    Ok(ExitCode::SUCCESS)
}
