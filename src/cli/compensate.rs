//! `paracal compensate`.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;

use crate::conditions::{ConditionKind, ConditionTable};
use crate::effect::{ActiveEffect, ActsOn, Compensated, Compensator};
use crate::files::{CalibrationSection, ListedPose, Machine, read_pose_list};
use crate::units::{Dimension, shortened};
use anyhow::{Context, Result, bail};
use serde_json::json;

use crate::cli::common::{Frame, joint_noun, verdict};
use crate::cli::guard::Guard;
use crate::cli::ui::Ui;
use crate::files::{JointsAndPose, joints_and_poses};

/// Arguments of `compensate`.
#[derive(clap::Args)]
#[command(after_help = "Example: paracal compensate calibrated.toml poses.csv -o lengths.csv")]
pub(crate) struct Args {
    /// Mechanism file, usually a calibrated one.
    mechanism: PathBuf,
    /// List of poses for the platform to take, in order. An extended model reads temperatures, elevation and payload
    /// from the same columns as in measurement files.
    poses: PathBuf,
    /// Table of the leg lengths (joint angles of a rotary mechanism) to command.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The poses are meant as the instrument sees them: the sag of its frame is compensated too.
    #[arg(long)]
    in_tracker_frame: bool,
    /// Frame of the model and of the poses in the data.
    #[arg(long, value_enum, default_value = "measurement")]
    frame: Frame,
    /// Command by a model whose file says that its calibration must not be trusted.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    let mut outputs = ui.outputs([&args.mechanism, &args.poses], [&args.output])?;
    let mut machine = ui.machine_in(&args.mechanism, args.frame)?;
    outputs.protect(machine.inputs());
    check_trust(&machine, args.force)?;
    let list = read_pose_list(&args.poses, &machine)?;
    let mut warnings = list.warnings.clone();
    let states = list.poses.iter().map(|l| &l.conditions);
    warnings.extend(machine.refer_to(states, &args.poses.display().to_string()));
    let mechanism = machine.plain();
    let mut compensator =
        Compensator::new(mechanism, machine.environment(), &machine.effects(), args.in_tracker_frame)?;
    warnings.extend(compensator.left_out().iter().map(not_compensated));

    let mut rows: Vec<Compensated> = Vec::with_capacity(list.poses.len());
    for (row, listed) in list.poses.iter().enumerate() {
        let found = compensator
            .command(&listed.pose, &listed.conditions)
            .with_context(|| format!("{}: data row {row}", args.poses.display()))?;
        if found.joints.iter().any(|v| !v.is_finite()) {
            bail!("{}: data row {row}: the pose is out of reach; correct the row", args.poses.display());
        }
        rows.push(found);
    }
    warnings.extend(lacking(&rows));
    warnings.extend(extrapolated(&rows, machine.condition_kinds()));
    let guard = Guard::of(&machine, &rows);
    warnings.extend(guard.warnings.iter().cloned());

    let table_row = |(listed, found): (&ListedPose, &Compensated)| JointsAndPose {
        id: listed.id.clone(),
        joints: found.joints.clone(),
        pose: machine.convention.coordinates(&found.seen),
    };
    let table_rows: Vec<JointsAndPose> = list.poses.iter().zip(&rows).map(table_row).collect();
    let noun = joint_noun(mechanism);
    let used: Vec<String> = compensator.compensated().map(ActiveEffect::label).collect();
    let with = if used.is_empty() { String::new() } else { format!(" with {}", used.join(", ")) };
    let by = machine.document().calibration.as_ref().map_or_else(String::new, |c| format!("; by a {}", c.in_words()));
    let comment = format!("{noun} to command for {}{with}{by}", mechanism.name());
    let mut table = joints_and_poses(&machine, comment, &table_rows);
    if !guard.is_clear() {
        table.append(&guard.column());
    }
    table.append(&list.covariates);
    outputs.add(&args.output, table.to_text())?;
    ui.write(outputs)?;
    warnings.iter().for_each(|w| ui.warn(w));
    guard.shown_strokes(noun).iter().for_each(|w| ui.warn(w));
    let lengths: Vec<&Vec<f64>> = rows.iter().map(|r| &r.joints).collect();
    let text = format!("{} poses: {noun} to command written to {}", rows.len(), args.output.display());
    let all: Vec<&String> = warnings.iter().chain(&guard.strokes).collect();
    let checks: Vec<String> = guard.checks.iter().map(ToString::to_string).collect();
    let mut shown = json!({
        "poses": rows.len(), "outside_stroke": guard.strokes.len(), "check": checks, "joints": lengths, "effects": used,
        "warnings": all,
    });
    if mechanism.joints().iter().all(|j| j.dimension == Dimension::Length) {
        shown["lengths_m"] = json!(lengths);
    }
    ui.result(&text, &shown)?;
    Ok(verdict(guard.is_clear()))
}

/// Refuses a model of which its own file says that it must not be trusted.
fn check_trust(machine: &Machine, force: bool) -> Result<()> {
    match &machine.document().calibration {
        Some(CalibrationSection { trusted: Some(false), reasons, .. }) if !force => {
            let why = if reasons.is_empty() { String::new() } else { format!(" ({})", reasons.join("; ")) };
            bail!(
                "{}: [calibration]: trusted = false{why}; calibrate with better data, or command by this model all the same \
                 with --force",
                machine.path.display()
            )
        }
        _ => Ok(()),
    }
}

/// Why an effect is not compensated.
fn not_compensated(effect: &ActiveEffect) -> String {
    let label = effect.label();
    match effect.effect.acts_on() {
        ActsOn::Measurement if !effect.effect.describes_one_run() => format!(
            "{label} is not compensated: only the instrument sees it; use --in-tracker-frame if the poses are meant \
             as the instrument sees them"
        ),
        ActsOn::Measurement => {
            format!(
                "{label} is not compensated: it moved the instrument during one run, and predicts nothing for \
                     another"
            )
        }
        ActsOn::Mechanism => {
            format!(
                "{label} is not compensated: it describes one run and cannot be extrapolated; find out what moved \
                 that leg"
            )
        }
    }
}

/// Which effects were left out in which rows, because a state lacks something.
fn lacking(rows: &[Compensated]) -> Vec<String> {
    let mut found: BTreeMap<(String, String), Vec<String>> = BTreeMap::new();
    for (row, compensated) in rows.iter().enumerate() {
        for (label, names) in &compensated.lacking {
            found.entry((label.clone(), names.join(", "))).or_default().push(row.to_string());
        }
    }
    let said = |((label, names), rows): (&(String, String), &Vec<String>)| {
        format!(
            "{label} is left out in data row {}: it needs {names}; add the column or fill in the cells",
            shortened(rows)
        )
    };
    found.iter().map(said).collect()
}

/// Where a covariate is outside of the range on which an effect was fitted.
struct Outside {
    rows: Vec<String>,
    /// Smallest and largest value there.
    values: [f64; 2],
    range: [f64; 2],
}

/// Which covariates are outside of the range on which an effect was fitted.
fn extrapolated(rows: &[Compensated], kinds: &ConditionTable) -> Vec<String> {
    let mut found: BTreeMap<(String, String), Outside> = BTreeMap::new();
    for (row, compensated) in rows.iter().enumerate() {
        for e in &compensated.outside {
            let first = || Outside { rows: Vec::new(), values: [e.value; 2], range: e.range };
            let outside = found.entry((e.effect.clone(), e.covariate.clone())).or_insert_with(first);
            outside.rows.push(row.to_string());
            outside.values = [outside.values[0].min(e.value), outside.values[1].max(e.value)];
        }
    }
    let mut said = Vec::with_capacity(found.len());
    for ((label, covariate), Outside { rows, values, range }) in found {
        let (unit, per_si) = shown_unit(&covariate, kinds);
        let [low, high] = values.map(|v| v * per_si);
        let [from, to] = range.map(|v| v * per_si);
        let value = if low == high { format!("{low:.4}") } else { format!("{low:.4} to {high:.4}") };
        said.push(format!(
            "{label}: {covariate} is {value}{unit} in data row {}, outside the range {from:.4} to {to:.4}{unit} over \
             which it was fitted; the command is an extrapolation",
            shortened(&rows)
        ));
    }
    said
}

/// The unit in which a covariate is shown, after a blank, and how many of it make one SI unit.
fn shown_unit(covariate: &str, kinds: &ConditionTable) -> (String, f64) {
    let unit = kinds.of(covariate).map(ConditionKind::unit).filter(|unit| unit.dimension != Dimension::None);
    unit.map_or_else(|| (String::new(), 1.0), |unit| (format!(" {}", unit.name), 1.0 / unit.factor))
}
