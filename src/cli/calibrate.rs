//! `paracal calibrate`.

use std::path::PathBuf;
use std::process::ExitCode;

use crate::files::{CalibrationSection, CsvTable, Machine, Measurement, number};
use crate::identification::{
    Calibration, CalibrationOptions, Holdout, IDENTIFIERS, Identifier, IdentifyError, LeastSquares, Loss, PriorPolicy,
    Robust, Weights, calibrate, deviations, identifier,
};
use crate::measurement::Dataset;
use crate::mechanism::Mechanism;
use crate::report::html::{self, Measured, ModelResiduals, Page};
use crate::report::{json, text};
use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use serde_json::Value;

use crate::cli::common::{Frame, about, page_subject, settings, sha256, verdict};
use crate::cli::ui::Ui;

#[derive(Clone, Copy, ValueEnum)]
enum Prior {
    /// Use the tolerances where the data do not determine the parameters.
    Auto,
    /// Always use the tolerances.
    Tolerance,
    /// Use no prior.
    None,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum WeightChoice {
    /// Weight rows by their noise.
    Noise,
    /// Unweighted millimetres and radians: the paper's estimator.
    None,
}

#[derive(Clone, Copy, ValueEnum)]
enum LossChoice {
    Huber,
    Tukey,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum SolverChoice {
    /// This program's QR steps.
    Qr,
    /// argmin's built-in Gauss-Newton.
    Argmin,
}

/// Arguments of `calibrate`.
#[derive(clap::Args)]
#[command(after_help = "Example: paracal calibrate mechanisms/table5.toml measured.csv -o calibrated.toml")]
pub(crate) struct Args {
    /// Mechanism file.
    mechanism: PathBuf,
    /// Measurement file: joints and measured values.
    data: PathBuf,
    /// Calibrated mechanism file to write; without it the result is only shown.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// levenberg-marquardt, least-squares (the paper's iteration) or robust.
    #[arg(long, default_value = "levenberg-marquardt", value_parser = clap::builder::PossibleValuesParser::new(IDENTIFIERS))]
    identifier: String,
    /// Whether to use the tolerances as prior knowledge.
    #[arg(long, value_enum, default_value = "auto")]
    prior: Prior,
    /// How to weight the rows.
    #[arg(long, value_enum, default_value = "noise")]
    weights: WeightChoice,
    /// Fraction of the rows to hold out (0 to 1), or a second measurement file; 5 folds if absent.
    #[arg(long, value_name = "PART|FILE")]
    holdout: Option<String>,
    /// Frame of the model and of the poses in the data.
    #[arg(long, value_enum, default_value = "measurement")]
    frame: Frame,
    /// Loss of the robust identifier.
    #[arg(long, value_enum, default_value = "tukey")]
    loss: LossChoice,
    /// Solver of the least-squares identifier.
    #[arg(long, value_enum, default_value = "qr")]
    solver: SolverChoice,
    /// Seed of the folds and of the poses at which errors are predicted.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Also write the covariance of the parameters (SI) as CSV.
    #[arg(long, value_name = "FILE")]
    covariance: Option<PathBuf>,
    /// HTML page to write: verdict, errors and parameters as charts.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
}

impl Args {
    /// The measurement file to hold out, if one is named.
    fn held_file(&self) -> Option<PathBuf> {
        self.holdout.as_ref().filter(|h| h.parse::<f64>().is_err()).map(PathBuf::from)
    }
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    let second = args.held_file();
    let inputs = [Some(&args.mechanism), Some(&args.data), second.as_ref()];
    let wanted = [&args.output, &args.covariance, &args.report].into_iter().flatten();
    let mut outputs = ui.outputs(inputs.into_iter().flatten(), wanted)?;
    let mut machine = ui.machine_in(&args.mechanism, args.frame)?;
    outputs.protect(machine.inputs());
    let measurement = ui.measurement(&args.data, &machine)?;
    ui.not_used(&measurement);
    ui.refer(&mut machine, &measurement.data, &args.data);
    let holdout = match (&args.holdout, &second) {
        (None, _) => Holdout::Folds(5),
        (_, Some(path)) => Holdout::Data(Box::new(ui.measurement(path, &machine).context("--holdout")?.data)),
        (Some(part), None) => match part.parse::<f64>() {
            Ok(part) if part > 0.0 && part < 1.0 => Holdout::Fraction(part),
            _ => bail!(
                "--holdout {part}: the fraction of the rows must be between 0 and 1, such as 0.2; or name a \
                        file"
            ),
        },
    };
    let options = CalibrationOptions {
        prior: match args.prior {
            Prior::Auto => PriorPolicy::Auto,
            Prior::Tolerance => PriorPolicy::Tolerance,
            Prior::None => PriorPolicy::None,
        },
        weights: match args.weights {
            WeightChoice::Noise => Weights::Noise,
            WeightChoice::None => Weights::MillimetresAndRadians,
        },
        holdout,
        seed: args.seed,
        convention: machine.convention,
    };
    let chosen = chosen_identifier(args)?;
    let progress = ui.progress(format!("calibrating with {} samples", measurement.data.len()));
    let mechanism = machine.mechanism.as_ref();
    let mut result = calibrate(mechanism, &measurement.data, machine.workspace.as_ref(), chosen.as_ref(), &options)
        .map_err(|error| match (error, &options.holdout, &second) {
            (IdentifyError::HeldOut(cause), Holdout::Data(held), Some(path)) => about(*cause, &machine, path, held),
            (error, ..) => about(error, &machine, &args.data, &measurement.data),
        })?;
    progress.finish_and_clear();

    let mut document = machine.calibrated_document(&result, &measurement)?;
    result.compare_with_written(machine.errors_as_written(&document, &measurement));
    let write = |path: &PathBuf| {
        document.calibration = Some(CalibrationSection {
            data_sha256: sha256(&args.data),
            drawing_sha256: sha256(&args.mechanism),
            ..CalibrationSection::of_calibration(&result, &machine)
        });
        outputs.add_mechanism(path, &document)
    };
    let written = args.output.as_ref().map(write).transpose()?;
    if let Some(path) = &args.covariance {
        outputs.add(path, covariance_table(&result).to_text())?;
    }
    if let Some(path) = &args.report {
        outputs.add(path, page(args, ui, &machine, &measurement, &result)?.html())?;
    }
    ui.write(outputs)?;
    let of_file = written.iter().flat_map(|written| &written.warnings);
    result.verdict.warnings.iter().chain(of_file).for_each(|w| ui.warn(w));
    ui.result(&text::calibration(&result), &object(args, &machine, &measurement, &result, ui)?)?;
    Ok(verdict(result.verdict.trusted))
}

/// The object for scripts; it is made only for those who read it.
fn object(args: &Args, machine: &Machine, measurement: &Measurement, result: &Calibration, ui: &Ui) -> Result<Value> {
    if !ui.json {
        return Ok(Value::Null);
    }
    let own = result.identification.own_values();
    let residuals = deviations(result.mechanism.as_ref(), &own, &measurement.data)
        .map_err(|error| about(error, machine, &args.data, &measurement.data))?;
    let mut object = json::calibration(result, &residuals);
    object["columns_not_used"] = measurement.columns_not_used.as_slice().into();
    if args.covariance.is_some() {
        object["covariance"] =
            result.covariance.row_iter().map(|row| row.iter().copied().collect()).collect::<Vec<Vec<f64>>>().into();
    }
    Ok(object)
}

/// The report: errors of the mechanism as it was given, once it stands where it was found, and of the calibrated one.
fn page(args: &Args, ui: &Ui, machine: &Machine, measurement: &Measurement, result: &Calibration) -> Result<Page> {
    let data = &measurement.data;
    let about = |error| about(error, machine, &args.data, data);
    let aligned = data.with_frames(result.registration.frames);
    let own = result.identification.own_values();
    let seen = |name: &str, mechanism: &dyn Mechanism, own: &[f64], data: &Dataset| {
        let residuals = ModelResiduals::new(name, mechanism, own, data).map_err(about)?;
        Ok::<_, anyhow::Error>(residuals.in_base(&html::frames_of(mechanism, machine.commander())))
    };
    let mut models = vec![seen("calibrated", result.mechanism.as_ref(), &own, data)?];
    if result.not_reached == 0 {
        models.push(seen("as given", machine.mechanism.as_ref(), &[], &aligned)?);
    }
    let settings =
        settings(Some(args.seed), machine.inputs().iter().chain([&args.data]).chain(args.held_file().as_ref()));
    let subject = page_subject(ui, machine, result.mechanism.as_ref(), settings);
    Ok(html::calibration(result, &subject, &Measured { data, models: &models }))
}

fn chosen_identifier(args: &Args) -> Result<Box<dyn Identifier>> {
    match args.identifier.as_str() {
        "least-squares" => Ok(Box::new(LeastSquares { builtin: args.solver == SolverChoice::Argmin })),
        "robust" if args.weights == WeightChoice::None => {
            bail!("--weights none: the robust identifier needs rows weighted by their noise; use least-squares")
        }
        "robust" => {
            let loss = match args.loss {
                LossChoice::Huber => Loss::Huber,
                LossChoice::Tukey => Loss::Tukey,
            };
            Ok(Box::new(Robust { loss, ..Robust::default() }))
        }
        name => identifier(name).with_context(|| format!("no identifier is called '{name}'")),
    }
}

fn covariance_table(result: &Calibration) -> CsvTable {
    let names = result.parameters[..result.identification.mechanism_parameters].iter().map(|p| p.spec.name.clone());
    let names: Vec<String> = names.collect();
    let row = |(k, name): (usize, &String)| {
        std::iter::once(name.clone()).chain(result.covariance.row(k).iter().map(|v| number(*v))).collect()
    };
    CsvTable {
        comments: vec!["covariance of the parameters, SI".into()],
        header: std::iter::once("parameter".to_owned()).chain(names.iter().cloned()).collect(),
        rows: names.iter().enumerate().map(row).collect(),
    }
}
