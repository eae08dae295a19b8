//! `paracal compensate`.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use paracal::conditions::Conditions;
use paracal::files::{ListedPose, Outputs, read_poses};
use paracal::mechanism::settled;
use paracal::pose::Pose;
use paracal::units::Dimension;
use serde_json::json;

use crate::common::{JointsAndPose, Ui, joint_noun, joints_and_poses};

/// Arguments of `compensate`.
#[derive(clap::Args)]
#[command(after_help = "Example: paracal compensate calibrated.toml poses.csv -o lengths.csv")]
pub(crate) struct Args {
    /// Mechanism file, usually a calibrated one.
    mechanism: PathBuf,
    /// List of poses that the platform should take.
    poses: PathBuf,
    /// Table of the leg lengths (joint angles of a rotary mechanism) to command.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    let mut outputs = Outputs::beside_inputs([&args.mechanism, &args.poses]);
    outputs.check(&args.output)?;
    let machine = ui.machine(&args.mechanism)?;
    outputs.protect(machine.inputs());
    let mechanism = machine.mechanism.as_ref();
    let poses = read_poses(&args.poses, &machine)?;
    let at = Conditions::unknown();
    let mut lengths = Vec::with_capacity(poses.len());
    let (mut poses_taken, mut outside) = (Vec::with_capacity(poses.len()), Vec::new());
    for (row, listed) in poses.iter().enumerate() {
        // A mechanism of lower mobility takes the pose as far as its joints control it.
        let (taken, joints) = settled(mechanism, mechanism.values(), &listed.pose, &at)
            .with_context(|| format!("{}: data row {row}", args.poses.display()))?;
        if joints.iter().any(|v| !v.is_finite()) {
            bail!("{}: data row {row}: the pose is too far for any leg; correct the row", args.poses.display());
        }
        for (spec, value) in mechanism.joints().iter().zip(&joints) {
            if let Some([from, to]) = spec.stroke.filter(|[from, to]| value < from || value > to) {
                let (unit, per_si) = spec.dimension.in_tables();
                outside.push(format!(
                    "data row {row}: {} would be {:.3} {unit}, outside its stroke {:.3} to {:.3} {unit}",
                    spec.name,
                    per_si * value,
                    per_si * from,
                    per_si * to
                ));
            }
        }
        lengths.push(joints);
        poses_taken.push(taken);
    }
    let row = |((listed, taken), joints): ((&ListedPose, &Pose), &Vec<f64>)| JointsAndPose {
        id: listed.id.clone(),
        joints: joints.clone(),
        pose: machine.convention.coordinates(taken),
    };
    let rows: Vec<JointsAndPose> = poses.iter().zip(&poses_taken).zip(&lengths).map(row).collect();
    let noun = joint_noun(mechanism);
    let comment = format!("{noun} to command for {}", mechanism.name());
    outputs.add(&args.output, joints_and_poses(&machine, comment, &rows).to_text())?;
    outputs.write()?;
    const SHOWN: usize = 5;
    outside.iter().take(SHOWN).for_each(|w| ui.warn(w));
    if outside.len() > SHOWN {
        ui.warn(&format!("{} more {noun} are outside their strokes", outside.len() - SHOWN));
    }
    let text = format!("{} poses: {noun} to command are in {}", poses.len(), args.output.display());
    let mut shown =
        json!({ "poses": poses.len(), "outside_stroke": outside.len(), "joints": lengths, "warnings": outside });
    if mechanism.joints().iter().all(|j| j.dimension == Dimension::Length) {
        shown["lengths_m"] = json!(lengths);
    }
    ui.result(&text, &shown);
    Ok(ExitCode::SUCCESS)
}
