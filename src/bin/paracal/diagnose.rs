//! `paracal diagnose`.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use paracal::diagnosis::{DiagnoseError, Question, Verdict, diagnose};
use paracal::files::Outputs;
use paracal::report::{json, text};

use crate::common::{Ui, about, verdict};

/// Arguments of `diagnose`.
#[derive(clap::Args)]
#[command(after_help = "Example: paracal diagnose mechanisms/table5.toml measured.csv -o extended.toml\n\n\
                        Verdicts: clean, named, tied (other names are not excluded), unknown (no name explains it), misread \
                        (exit code 3; nothing is fitted).")]
pub(crate) struct Args {
    /// Mechanism file; effects in it are looked for anew.
    mechanism: PathBuf,
    /// Measurement file with the conditions of each row: temperatures, elevation, payload, time.
    data: PathBuf,
    /// Mechanism file to write: identified parameters and the causes that were found.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Take the stated noise as known; otherwise its size is estimated and only its ratio is used.
    #[arg(long)]
    noise_known: bool,
    /// Seed of the held-out folds.
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    let mut outputs = Outputs::beside_inputs([&args.mechanism, &args.data]);
    if let Some(path) = &args.output {
        outputs.check(path)?;
    }
    let machine = ui.machine(&args.mechanism)?.without_effects()?;
    outputs.protect(machine.inputs());
    let measurement = ui.measurement(&args.data, &machine)?;
    if args.noise_known && !measurement.data.noise.known {
        bail!("--noise-known: {} states no [noise], and the data no sigma columns", args.mechanism.display());
    }
    let question =
        Question { noise_known: args.noise_known, seed: args.seed, ..Question::of(&machine, &measurement.as_read) };
    let progress = ui.progress(format!("looking for causes in {} samples", measurement.data.len()));
    let found = diagnose(&question).map_err(|error| match error {
        DiagnoseError::Identify(cause) => about(cause, &machine, &args.data, &measurement.data),
        other => anyhow::Error::new(other).context(args.data.display().to_string()),
    })?;
    progress.finish_and_clear();
    found.warnings.iter().for_each(|w| ui.warn(w));
    if let Some(path) = &args.output {
        if found.verdict == Verdict::Misread {
            ui.warn(&format!("{} is not written: the data were read wrongly", path.display()));
        } else {
            let document = machine.extended_document(&found).context("the extended model")?;
            let written = outputs.add_mechanism(path, &document)?;
            written.warnings.iter().for_each(|w| ui.warn(w));
            outputs.write()?;
        }
    }
    ui.result(&text::diagnosis(&found, machine.mechanism.name()), &json::diagnosis(&found));
    Ok(verdict(found.verdict != Verdict::Misread))
}
