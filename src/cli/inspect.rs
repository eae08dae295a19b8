//! `paracal inspect`.

use std::path::PathBuf;
use std::process::ExitCode;

use crate::conditions::Conditions;
use crate::effect::{ActiveEffect, ActsOn, EffectContext, EffectParameter};
use crate::files::Machine;
use crate::identification::{DataSpectrum, WeakDirection, weak_directions};
use crate::measurement::Noise;
use crate::mechanism::{Body, Mechanism, Survey, characteristic_length, condition};
use crate::report::{json as reported, text};
use crate::selection::{Preview, preview};
use crate::units::{Dimension, show_quantity};
use anyhow::Result;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use serde_json::{Value, json};

use crate::cli::ui::Ui;

/// Arguments of `inspect`.
#[derive(clap::Args)]
#[command(after_help = "Example: paracal inspect mechanisms/rubin-camera-hexapod.toml")]
pub(crate) struct Args {
    /// Mechanism file.
    mechanism: PathBuf,
}

const POSES: usize = 20;
const SURVEYED: usize = 1000;

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    // The warnings of the file are part of the result, too.
    let machine = ui.machine(&args.mechanism)?;
    let mechanism = machine.mechanism.as_ref();
    let c = mechanism.values();
    let at = Conditions::unknown();
    let joints = mechanism.inverse(c, &mechanism.home(), &at)?;
    let mut warnings = machine.warnings.clone();
    warnings.extend(machine.note_on_home());
    let survey = machine.workspace.as_ref().map(|w| {
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let poses: Vec<_> = (0..SURVEYED).map(|_| w.random(&mut rng)).collect();
        Survey::of(mechanism, w, &poses)
    });
    if let Some(s) = &survey {
        if s.unreachable > 0 {
            warnings.push(format!("{} of {} poses in the workspace cannot be reached", s.unreachable, s.poses));
        }
        if s.outside_stroke > 0 {
            warnings.push(format!(
                "{} of {} poses in the workspace need a joint outside its stroke",
                s.outside_stroke, s.poses
            ));
        }
    }
    let outlook = match (&machine.workspace, &machine.noise) {
        (Some(w), Some(noise)) => look_ahead(&machine, w, noise, &mut warnings),
        _ => {
            warnings.push("state [workspace] and [noise] to see what 20 poses would determine".into());
            None
        }
    };
    let mut seen = text::Inspection {
        mechanism,
        convention: &machine.convention,
        platform: Body::Platform.points(mechanism, c),
        base: Body::Base.points(mechanism, c),
        lengths: Vec::new(),
        home_joints: joints.clone(),
        radius: characteristic_length(mechanism),
        home_condition: condition(mechanism, c, &joints, &mechanism.home(), &at),
        survey,
        weak: outlook.as_ref().map(|p| weak(mechanism, p)).unwrap_or_default(),
        preview: outlook,
        warnings,
    };
    seen.lengths = lengths(mechanism, seen.legs(), &seen.home_joints);
    let mut shown = reported::inspection(&seen);
    shown["joints"] = machine.joint_names().into();
    let mut report = text::inspection(&seen);
    if machine.joint_names().iter().zip(mechanism.joints()).any(|(own, j)| *own != j.name) {
        let report_joints = machine.joint_names().join(", ");
        report += &format!("\n\nJoints of the legs in URDF and in data columns: {report_joints}");
    }
    let effects = machine.effects();
    shown["effects"] = effects.iter().map(|e| effect_json(&machine, e)).collect();
    if !effects.is_empty() {
        let lines: Vec<String> = effects.iter().map(|e| format!("  {}", effect_text(&machine, e))).collect();
        report += &format!("\n\nEffects:\n{}", lines.join("\n"));
    }
    ui.result(&report, &shown)?;
    Ok(ExitCode::SUCCESS)
}

fn effect_json(machine: &Machine, effect: &ActiveEffect) -> Value {
    let parameters = parameters(machine, effect);
    let parameter =
        |(p, value): &(EffectParameter, f64)| json!({ "name": p.name, "value": value, "unit": p.dimension.si() });
    json!({
        "effect": effect.effect.name(),
        "leg": effect.at.leg.map(|leg| leg + 1),
        "row": effect.at.row,
        "of": effect.at.covariate,
        "parameters": parameters.iter().map(parameter).collect::<Vec<_>>(),
        "range": effect.range,
    })
}

fn effect_text(machine: &Machine, effect: &ActiveEffect) -> String {
    let value = |(p, value): &(EffectParameter, f64)| format!("{} {}", p.name, show_quantity(*value, p.dimension));
    let values: Vec<String> = parameters(machine, effect).iter().map(value).collect();
    let seen = if effect.effect.acts_on() == ActsOn::Measurement { " (seen by the instrument only)" } else { "" };
    format!("{}{seen}: {}", effect.label(), values.join(", "))
}

fn parameters(machine: &Machine, effect: &ActiveEffect) -> Vec<(EffectParameter, f64)> {
    let context = EffectContext::new(machine.plain(), machine.environment());
    effect.effect.parameters(&context).into_iter().zip(effect.values.iter().copied()).collect()
}

/// Lengths of the legs: nominal ones, those of rods, or of joints that are legs; NaN where there is none.
fn lengths(mechanism: &dyn Mechanism, legs: usize, home_joints: &[f64]) -> Vec<f64> {
    let named = |stem: &str, leg: usize| {
        let name = format!("{stem}{}", leg + 1);
        let found = mechanism.parameters().iter().zip(mechanism.values()).find(|(s, _)| s.name == name);
        found.filter(|(s, _)| s.dimension == Dimension::Length)
    };
    let of_joint = |leg: usize| {
        let own = legs == home_joints.len() && mechanism.joints()[leg].dimension == Dimension::Length;
        if own { home_joints[leg] } else { f64::NAN }
    };
    let length = |leg: usize| match (named("h", leg), named("s", leg)) {
        (Some((spec, _)), _) => spec.nominal,
        (None, Some((_, value))) => *value,
        (None, None) => of_joint(leg),
    };
    (0..legs).map(length).collect()
}

fn look_ahead(
    machine: &Machine,
    workspace: &crate::mechanism::Workspace,
    noise: &Noise,
    warnings: &mut Vec<String>,
) -> Option<Preview> {
    match preview(machine.mechanism.as_ref(), workspace, noise, POSES, 0) {
        Ok(found) => Some(found),
        Err(cause) => {
            warnings.push(format!("what 20 poses would determine is not known: {cause}"));
            None
        }
    }
}

/// Directions that the poses of a preview would not decide, in words.
fn weak(mechanism: &dyn Mechanism, preview: &Preview) -> Vec<WeakDirection> {
    let spectrum = DataSpectrum {
        values: preview.forecast.spectrum.values.clone(),
        directions: preview.forecast.spectrum.directions.clone(),
        scale: preview.scale.clone(),
        scaled_by_tolerance: mechanism.parameters().iter().all(|s| s.tolerance.is_some()),
    };
    weak_directions(mechanism, &spectrum)
}
