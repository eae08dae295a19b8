//! `paracal evaluate`.

use std::path::PathBuf;
use std::process::ExitCode;

use crate::identification::evaluate;
use crate::report::html::{self, Measured, ModelResiduals};
use crate::report::{json, text};
use anyhow::Result;

use crate::cli::common::{Frame, about, page_subject, settings};
use crate::cli::ui::Ui;

/// Arguments of `evaluate`.
#[derive(clap::Args)]
#[command(after_help = "Example: paracal evaluate calibrated.toml other-day.csv")]
pub(crate) struct Args {
    /// Mechanism file, nominal or calibrated.
    mechanism: PathBuf,
    /// Measurement file.
    data: PathBuf,
    /// Frame of the model and of the poses in the data.
    #[arg(long, value_enum, default_value = "measurement")]
    frame: Frame,
    /// HTML page to write: the errors as charts.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
}

/// A nominal model that misses by this part of the platform's radius is likely to be in another frame.
const OTHER_FRAME: f64 = 0.05;

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    let mut outputs = ui.outputs([&args.mechanism, &args.data], &args.report)?;
    let mut machine = ui.machine_in(&args.mechanism, args.frame)?;
    outputs.protect(machine.inputs());
    let measurement = ui.measurement(&args.data, &machine)?;
    ui.not_used(&measurement);
    ui.refer(&mut machine, &measurement.data, &args.data);
    let mechanism = machine.mechanism.as_ref();
    let wrong = |error| about(error, &machine, &args.data, &measurement.data);
    let errors = evaluate(mechanism, &[], &measurement.data).map_err(wrong)?;
    let size = crate::mechanism::characteristic_length(mechanism);
    if errors.rms().position.is_some_and(|p| p > OTHER_FRAME * size) {
        ui.warn(&format!("the errors are as large as the mechanism; {}", measurement.kind.advice_on_frames()));
    }
    if let Some(path) = &args.report {
        let subject =
            page_subject(ui, &machine, mechanism, settings(None, machine.inputs().iter().chain([&args.data])));
        let residuals = ModelResiduals::new("model", mechanism, &[], &measurement.data).map_err(wrong)?;
        let models = [residuals.in_base(&subject.frames)];
        let measured = Measured { data: &measurement.data, models: &models };
        outputs.add(path, html::evaluation(&errors, &subject, &measured).html())?;
        ui.write(outputs)?;
    }
    let mut object = json::evaluation(&errors);
    object["columns_not_used"] = measurement.columns_not_used.as_slice().into();
    ui.result(&text::evaluation(&errors, mechanism.name()), &object)?;
    Ok(ExitCode::SUCCESS)
}
