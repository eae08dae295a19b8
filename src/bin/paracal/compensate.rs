//! `paracal compensate`.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use paracal::conditions::Conditions;
use paracal::files::{CsvTable, ListedPose, Machine, Outputs, number, read_poses};
use serde_json::json;

use crate::common::Ui;

/// Arguments of `compensate`.
#[derive(clap::Args)]
#[command(after_help = "Example: paracal compensate calibrated.toml poses.csv -o lengths.csv")]
pub(crate) struct Args {
    /// Mechanism file, usually a calibrated one.
    mechanism: PathBuf,
    /// List of poses that the platform should take.
    poses: PathBuf,
    /// Table of the leg lengths to command.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    let mut outputs = Outputs::beside_inputs([&args.mechanism, &args.poses]);
    outputs.check(&args.output)?;
    let machine = ui.machine(&args.mechanism)?;
    let mechanism = machine.mechanism.as_ref();
    let poses = read_poses(&args.poses, &machine)?;
    let at = Conditions::unknown();
    let mut lengths = Vec::with_capacity(poses.len());
    let mut outside = Vec::new();
    for (row, listed) in poses.iter().enumerate() {
        let joints = mechanism
            .inverse(mechanism.values(), &listed.pose, &at)
            .with_context(|| format!("{}: data row {row}", args.poses.display()))?;
        if joints.iter().any(|v| !v.is_finite()) {
            bail!("{}: data row {row}: the pose is too far for any leg; correct the row", args.poses.display());
        }
        for (spec, value) in mechanism.joints().iter().zip(&joints) {
            if let Some([from, to]) = spec.stroke.filter(|[from, to]| value < from || value > to) {
                outside.push(format!(
                    "data row {row}: {} would be {:.3} mm, outside its stroke {:.3} to {:.3} mm",
                    spec.name,
                    1e3 * value,
                    1e3 * from,
                    1e3 * to
                ));
            }
        }
        lengths.push(joints);
    }
    outputs.add(&args.output, commands(&machine, &poses, &lengths).to_text())?;
    outputs.write()?;
    const SHOWN: usize = 5;
    outside.iter().take(SHOWN).for_each(|w| ui.warn(w));
    if outside.len() > SHOWN {
        ui.warn(&format!("{} more lengths are outside their strokes", outside.len() - SHOWN));
    }
    let text = format!("{} poses: lengths to command are in {}", poses.len(), args.output.display());
    let shown =
        json!({ "poses": poses.len(), "outside_stroke": outside.len(), "lengths_m": lengths, "warnings": outside });
    ui.result(&text, &shown);
    Ok(ExitCode::SUCCESS)
}

/// Poses and the lengths that lead there, in the units of the mechanism file.
fn commands(machine: &Machine, poses: &[ListedPose], lengths: &[Vec<f64>]) -> CsvTable {
    let (length, angle) = (machine.length_unit, machine.angle_unit);
    let labelled = poses.iter().any(|p| p.id.is_some());
    let mut header: Vec<String> = if labelled { vec!["id".into()] } else { Vec::new() };
    header.extend(machine.mechanism.joints().iter().map(|j| format!("{}_{}", j.name, length.name)));
    header.extend(["x", "y", "z"].map(|c| format!("{c}_{}", length.name)));
    header.extend(["rx", "ry", "rz"].map(|c| format!("{c}_{}", angle.name)));
    let row = |(listed, joints): (&ListedPose, &Vec<f64>)| {
        let q = machine.convention.coordinates(&listed.pose);
        let mut cells: Vec<String> = if labelled { vec![listed.id.clone().unwrap_or_default()] } else { Vec::new() };
        cells.extend(joints.iter().map(|v| number(length.from_si(*v))));
        cells.extend(q[..3].iter().map(|v| number(length.from_si(*v))));
        cells.extend(q[3..].iter().map(|v| number(angle.from_si(*v))));
        cells
    };
    let comment = format!("lengths to command for {}", machine.mechanism.name());
    CsvTable { comments: vec![comment], header, rows: poses.iter().zip(lengths).map(row).collect() }
}
