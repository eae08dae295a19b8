//! The program `paracal`: one file for each subcommand, and what they share.
//!
//! A subcommand reads its arguments, calls the library, and hands results to [`report`](crate::report) and
//! [`files`](crate::files); it computes nothing itself. Progress bars live here.

mod calibrate;
mod campaign_limits;
mod case;
mod common;
mod compensate;
mod completions;
mod convert;
mod diagnose;
mod effect_args;
mod evaluate;
mod guard;
mod inspect;
mod new;
mod reproduce;
pub mod reproduction;
mod select;
mod select_args;
mod select_list;
mod settle;
mod simulate;
mod ui;
mod urdf_args;

use std::cell::{Cell, RefCell};
use std::process::ExitCode;

use anyhow::Result;
use clap::{CommandFactory, Parser, Subcommand};

use crate::files::ReadOptions;
pub use effect_args::effect_entry;
use ui::{Ui, report_error};

/// Calibrates parallel mechanisms: six-hardpoint mirror positioners, hexapods, Stewart platforms.
#[derive(Parser)]
#[command(version, about, propagate_version = true)]
#[command(
    after_help = "Exit codes: 0 done; 2 the input or the command line is wrong, nothing was written; 3 done, but the \
                  result must not be trusted (it is written, unless diagnose finds that the file was misread)."
)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Print one JSON object, and nothing else, on standard output.
    #[arg(long, global = true)]
    json: bool,
    /// Suppress progress and warnings.
    #[arg(long, global = true)]
    quiet: bool,
    /// Number of threads; the results do not depend on it.
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
    #[command(flatten)]
    urdf: urdf_args::UrdfArgs,
}

#[derive(Subcommand)]
enum Command {
    /// Print a mechanism file to start from, with a comment on every key.
    New(new::Args),
    /// Show geometry, home, strokes, conditioning, and what 20 well-chosen poses would determine.
    Inspect(inspect::Args),
    /// Choose the poses to measure, and prove how good the choice is.
    Select(select_args::Args),
    /// Simulate what a tracker would measure on a mechanism with errors.
    Simulate(simulate::Args),
    /// Identify the parameters from measured data, and say how far to trust them.
    Calibrate(calibrate::Args),
    /// Name what the model gets wrong, and say how much is gained by modelling it.
    Diagnose(diagnose::Args),
    /// Plan extra measurements that would separate tied causes.
    Settle(settle::Args),
    /// Compute the errors of a model on measured data; nothing is fitted.
    Evaluate(evaluate::Args),
    /// Compute the leg lengths to command for given poses.
    Compensate(compensate::Args),
    /// Convert a mechanism to URDF or to TOML.
    Convert(convert::Args),
    /// Reproduce the tables and figures of Yu, Wu, Wang 2023, and say what holds.
    Reproduce(reproduce::Args),
    /// Print what a shell needs to complete commands and options.
    Completions(completions::Args),
}

/// Runs the program on the arguments of the process.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return refuse_call(&error),
    };
    if let Some(threads) = cli.threads {
        // It fails only if a pool exists already, and this is the first use.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
    }
    run(&cli).unwrap_or_else(|error| report_error(&error, cli.json))
}

/// Prints what is wrong with a call, or the help that it asks for; for scripts also as an object.
fn refuse_call(error: &clap::Error) -> ExitCode {
    let json = error.use_stderr() && std::env::args_os().any(|word| word == "--json");
    if json {
        let text = error.to_string();
        return report_error(&anyhow::anyhow!("{}", text.trim().trim_start_matches("error: ")), json);
    }
    error.exit()
}

/// Runs what a call asks for.
///
/// # Errors
/// What is wrong with the call, the files that it names or the place of its outputs.
pub fn run(cli: &Cli) -> Result<ExitCode> {
    let reading = ReadOptions { urdf: cli.urdf.options()?, ..ReadOptions::default() };
    let ui =
        Ui { json: cli.json, quiet: cli.quiet, reading, warnings: RefCell::default(), file_on_stdout: Cell::default() };
    match &cli.command {
        Command::New(args) => new::run(args, &ui),
        Command::Inspect(args) => inspect::run(args, &ui),
        Command::Select(args) => select::run(args, &ui),
        Command::Simulate(args) => simulate::run(args, &ui),
        Command::Calibrate(args) => calibrate::run(args, &ui),
        Command::Diagnose(args) => diagnose::run(args, &ui),
        Command::Settle(args) => settle::run(args, &ui),
        Command::Evaluate(args) => evaluate::run(args, &ui),
        Command::Compensate(args) => compensate::run(args, &ui),
        Command::Convert(args) => convert::run(args, &ui),
        Command::Reproduce(args) => reproduce::run(args, &ui),
        Command::Completions(args) => completions::run(args, Cli::command()),
    }
}
