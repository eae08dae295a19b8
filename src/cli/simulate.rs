//! `paracal simulate`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use crate::effect::{ActiveEffect, AvailableData, EffectContext, Extended, effects_of, without_effects};
use crate::files::{
    CsvTable, EffectEntry, ListedPose, Machine, PoseList, READING_KINDS, read_parameter_errors, read_pose_list,
    reading_kind,
};
use crate::measurement::{Frames, Noise};
use crate::mechanism::Mechanism;
use crate::simulation::{Command, Instrument, SimulatedSample, draw_parameters, simulate_run};
use crate::units::{Dimension, parse_quantity, shortened};
use anyhow::{Context, Result, anyhow, bail};
use clap::builder::PossibleValuesParser;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use serde_json::json;

use crate::cli::effect_args::effect_entry;
use crate::cli::ui::Ui;
use crate::files::{JointsAndPose, labelled_joints};

/// Arguments of `simulate`.
#[derive(clap::Args)]
#[command(
    after_help = "Example: paracal simulate mechanisms/table5.toml --poses poses.csv -o data.csv --error-sd 0.5mm --truth truth.toml"
)]
pub(crate) struct Args {
    /// Nominal mechanism file, from which the commanded lengths are computed.
    mechanism: PathBuf,
    /// List of poses to command.
    #[arg(long, value_name = "FILE")]
    poses: PathBuf,
    /// Measurement file to write.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Draw a normal error with this standard deviation for every length; it is divided by the mean radius of the
    /// platform points for angles, and other parameters take their tolerance, if it is stated. Or `tolerance`: every
    /// parameter takes its own.
    #[arg(long, value_name = "LENGTH|tolerance", conflicts_with = "errors")]
    error_sd: Option<String>,
    /// Table of parameter errors: leg,xA_mm,yA_mm,zA_mm,xB_mm,yB_mm,zB_mm,h_mm; for other mechanisms their own
    /// parameters, such as o_deg.
    #[arg(long, value_name = "FILE")]
    errors: Option<PathBuf>,
    /// An effect on the true mechanism or on the instrument: NAME=VALUE,… or NAME[leg=3]=VALUE,…, with row=40 or of=temp_x
    /// in the brackets where the effect needs them, and lag_s=1800 where temperatures act late. Values are in SI, one for each parameter in order. Repeat for more
    /// effects. The list of poses is the run; its columns state temperatures, elevation, payload and time.
    #[arg(long = "effect", value_name = "NAME[leg=3]=VALUE,…")]
    effects: Vec<String>,
    /// 1 sigma of a measured position coordinate; that of the mechanism file if absent.
    #[arg(long, value_name = "LENGTH")]
    noise_position: Option<String>,
    /// 1 sigma of a measured angle; that of the mechanism file if absent.
    #[arg(long, value_name = "ANGLE")]
    noise_rotation: Option<String>,
    /// What is measured: full poses, the positions of the targets of the mechanism file (p1x_mm …), or the height over its
    /// plane (contact_mm); a height has the noise of a position.
    #[arg(long, default_value = "pose", value_parser = PossibleValuesParser::new(READING_KINDS.map(|kind| kind.name())))]
    measure: String,
    /// Random seed of errors and noise.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Also write the true mechanism.
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    let inputs = [Some(&args.mechanism), Some(&args.poses), args.errors.as_ref()];
    let mut outputs = ui.outputs(inputs.into_iter().flatten(), std::iter::once(&args.output).chain(&args.truth))?;
    // `None` within draws by the tolerances.
    let error_sd = match args.error_sd.as_deref() {
        Some("tolerance") => Some(None),
        _ => quantity("error-sd", &args.error_sd, Dimension::Length)?.map(Some),
    };
    let position = quantity("noise-position", &args.noise_position, Dimension::Length)?;
    let rotation = quantity("noise-rotation", &args.noise_rotation, Dimension::Angle)?;
    let machine = ui.machine(&args.mechanism)?;
    outputs.protect(machine.inputs());
    let list = read_pose_list(&args.poses, &machine)?;
    list.warnings.iter().for_each(|w| ui.warn(w));
    let actual = with_effects(&machine, &args.effects, &list, &args.poses, ui)?;
    let (mechanism, listed) = (actual.plain(), &list.poses);
    let stated = machine.noise.unwrap_or(Noise::stated(0.0, 0.0));
    let noise = Noise {
        position: position.unwrap_or(stated.position),
        rotation: rotation.unwrap_or(stated.rotation),
        ..stated
    };
    let mut rng = ChaCha8Rng::seed_from_u64(args.seed);
    let values = true_values(args, mechanism, error_sd, &mut rng)?;
    let truth = true_mechanism(&actual, &values)?;
    let run: Vec<Command> = listed.iter().map(|l| Command { pose: l.pose, state: l.conditions.clone() }).collect();
    let context = EffectContext::new(mechanism, actual.environment());
    let instrument = Instrument { context: &context, effects: actual.instrument() };
    let convention = &machine.convention;
    let simulated = simulate_run(mechanism, truth.as_ref(), &run, Some(&instrument), convention, &noise, &mut rng);
    let samples = simulated.map_err(|(row, cause)| {
        let advice = "choose poses nearer to home, or smaller errors";
        anyhow!("{}: data row {row}: {cause}; {advice}", args.poses.display())
    })?;
    warn_outside(ui, mechanism, &samples);
    let kind = reading_kind(&args.measure).with_context(|| format!("no kind of reading is '{}'", args.measure))?;
    let shown_noise = kind.shown_noise(&noise);
    let comment = format!("simulated: {}, noise {shown_noise}, seed {}", mechanism.name(), args.seed);
    let mut table = commands(&machine, comment, listed, &samples);
    table.append(&kind.simulate(&machine, &samples, &noise, &mut rng)?);
    table.append(&list.covariates);
    outputs.add(&args.output, table.to_text())?;
    if let Some(path) = &args.truth {
        let plain = without_effects(truth.as_ref());
        let (workspace, frames, effects) = (machine.workspace.as_ref(), Frames::default(), actual.effects());
        let document = machine.document_with_effects(plain, workspace, &frames, &effects, &[], actual.environment())?;
        let written = outputs.add_mechanism(path, &document)?;
        written.warnings.iter().for_each(|w| ui.warn(w));
    }
    ui.write(outputs)?;
    let effects: Vec<String> = actual.effects().iter().map(ActiveEffect::label).collect();
    let text =
        format!("{} samples in {}: noise {shown_noise}, seed {}", samples.len(), args.output.display(), args.seed);
    let shown = json!({
        "rows": samples.len(), "noise_position_m": noise.position, "noise_rotation_rad": noise.rotation,
        "seed": args.seed, "true_values": without_effects(truth.as_ref()).values(), "effects": effects,
    });
    ui.result(&text, &shown)?;
    Ok(ExitCode::SUCCESS)
}

/// A quantity of the call that must not be negative.
fn quantity(option: &str, text: &Option<String>, dimension: Dimension) -> Result<Option<f64>> {
    let Some(text) = text else { return Ok(None) };
    match parse_quantity(text, dimension) {
        Ok(value) if value < 0.0 => Err(anyhow!("--{option} {text}: must not be negative")),
        Ok(value) => Ok(Some(value)),
        Err(cause) => Err(anyhow!("--{option}: {cause}")),
    }
}

/// Values of the parameters of the true mechanism. Errors are drawn with one standard deviation, or with the tolerances
/// if that is `None`.
fn true_values(
    args: &Args,
    mechanism: &dyn Mechanism,
    error_sd: Option<Option<f64>>,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<f64>> {
    match (&args.errors, error_sd) {
        (Some(path), _) => {
            let errors = read_parameter_errors(path, mechanism)?;
            Ok(mechanism.values().iter().zip(errors).map(|(v, e)| v + e).collect())
        }
        (None, Some(None)) if mechanism.parameters().iter().all(|p| p.tolerance.is_none()) => {
            bail!("{}: --error-sd tolerance: state [tolerance], or give a length", args.mechanism.display())
        }
        (None, Some(sd)) => Ok(draw_parameters(mechanism, sd, rng)),
        (None, None) => Ok(mechanism.values().to_vec()),
    }
}

/// The mechanism of these values with the effects of the machine.
fn true_mechanism(actual: &Machine, values: &[f64]) -> Result<Box<dyn Mechanism>> {
    let inner = actual.plain().with_values(values, actual.plain().home())?;
    let moving = effects_of(actual.mechanism.as_ref()).to_vec();
    Ok(match moving.is_empty() {
        true => inner,
        false => Box::new(Extended::new(inner, Arc::clone(actual.environment()), moving)),
    })
}

/// The commanded joints of the rows, with their labels.
fn commands(machine: &Machine, comment: String, listed: &[ListedPose], samples: &[SimulatedSample]) -> CsvTable {
    let row = |(listed, sample): (&ListedPose, &SimulatedSample)| JointsAndPose {
        id: listed.id.clone(),
        joints: sample.joints.clone(),
        pose: sample.measured,
    };
    let rows: Vec<JointsAndPose> = listed.iter().zip(samples).map(row).collect();
    labelled_joints(machine, comment, &rows)
}

/// The machine with the effects of its file and of the call, which refer to the temperatures of the list.
fn with_effects(machine: &Machine, asked: &[String], list: &PoseList, path: &Path, ui: &Ui) -> Result<Machine> {
    let own = machine.effects().len();
    let mut document = machine.document().clone();
    for text in asked {
        let (entry, active) = effect_entry(text, machine)?;
        let before = document.effects.iter().any(|e| e.label() == entry.label());
        if before {
            bail!(
                "--effect '{text}': {} is stated twice, in the call or in the mechanism file; keep \
                   one",
                active.label()
            );
        }
        document.effects.push(entry);
    }
    let mut actual = machine.with_document(document)?;
    let states = || list.poses.iter().map(|l| &l.conditions);
    actual.refer_to(states(), &path.display().to_string()).iter().for_each(|w| ui.warn(w));
    let context = EffectContext::new(actual.plain(), actual.environment());
    let labels: Vec<String> = actual.document().effects.iter().map(EffectEntry::label).collect();
    for effect in actual.effects() {
        let lacking = states().map(|s| effect.lacking(&context, &AvailableData::of_state(s)));
        let Some((row, names)) = lacking.enumerate().find(|(_, names)| !names.is_empty()) else { continue };
        let (label, names) = (effect.label(), names.join(", "));
        let problem = format!("{}: data row {row}: {label} needs {names}", path.display());
        if labels.iter().position(|l| *l == label).is_some_and(|k| k >= own) {
            bail!("{problem}; add the column or fill in the cell");
        }
        ui.warn(&format!("{problem}; without it the effect does nothing"));
    }
    drop(context);
    Ok(actual)
}

fn warn_outside(ui: &Ui, mechanism: &dyn Mechanism, samples: &[SimulatedSample]) {
    let outside = samples.iter().enumerate().filter(|(_, s)| !mechanism.within_strokes(&s.joints));
    let rows: Vec<String> = outside.map(|(row, _)| row.to_string()).collect();
    if !rows.is_empty() {
        ui.warn(&format!("joints outside their stroke in data row {}", shortened(&rows)));
    }
}
