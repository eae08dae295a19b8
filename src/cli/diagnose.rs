//! `paracal diagnose`.

use std::path::PathBuf;
use std::process::ExitCode;

use crate::diagnosis::{Question, Verdict, diagnose, settle};
use crate::report::{html, json, text};
use anyhow::{Context, Result};

use crate::cli::case::CaseArgs;
use crate::cli::common::{page_subject, settings, sha256, verdict};
use crate::cli::ui::Ui;
use crate::files::CalibrationSection;

/// Arguments of `diagnose`.
#[derive(clap::Args)]
#[command(after_help = "Example: paracal diagnose mechanisms/table5.toml measured.csv -o extended.toml\n\n\
                        Verdicts: clean, named, tied (other names are not excluded), unknown (no name explains it), \
                        undecided (the data cannot tell; exit code 3), misread (exit code 3; nothing is fitted).")]
pub(crate) struct Args {
    #[command(flatten)]
    case: CaseArgs,
    /// Mechanism file to write: identified parameters and the causes found.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// HTML page to write: verdict, causes and limits as charts.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Seed of the held-out folds.
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    let written = [args.output.as_ref(), args.report.as_ref()];
    let (case, mut outputs) = args.case.read(&written, ui)?;
    let (machine, data) = (&case.machine, &case.measurement.data);
    let question = Question { seed: args.seed, ..case.question() };
    let progress = ui.progress(format!("looking for causes in {} samples", data.len()));
    let found = diagnose(&question).map_err(|error| case.about(error))?;
    progress.finish_and_clear();
    found.warnings.iter().for_each(|w| ui.warn(w));
    if let Some(path) = &args.output {
        if found.values.is_empty() {
            ui.warn(&format!("{} is not written: nothing was identified", path.display()));
        } else {
            let mut document = machine.extended_document(&found).context("the extended model")?;
            document.calibration = Some(CalibrationSection {
                data_sha256: sha256(&args.case.data),
                drawing_sha256: sha256(&args.case.mechanism),
                ..CalibrationSection::of_diagnosis(&found, machine, data.len())
            });
            let written = outputs.add_mechanism(path, &document)?;
            written.warnings.iter().for_each(|w| ui.warn(w));
        }
    }
    if let Some(path) = &args.report {
        let progress = ui.progress("looking for measurements that break the tie".into());
        let plans = settle(&question, &found).map_err(|error| case.about(error))?;
        progress.finish_and_clear();
        let settings = settings(Some(args.seed), machine.inputs().iter().chain([&args.case.data]));
        let subject = page_subject(ui, machine, machine.mechanism.as_ref(), settings);
        outputs.add(path, html::diagnosis(&found, &plans, &subject, data).html())?;
    }
    ui.write(outputs)?;
    ui.result(&text::diagnosis(&found, machine.mechanism.name()), &json::diagnosis(&found))?;
    let misfit = found.unknown.as_ref().is_some_and(|u| u.kind() == "misfit");
    Ok(verdict(!misfit && !matches!(found.verdict, Verdict::Misread | Verdict::Undecided)))
}
