//! What a named cause means at the machine, in a sentence for readers who read only one.

#[cfg(test)]
mod tests;

use std::f64::consts::TAU;

use crate::diagnosis::{Cause, CauseParameter, Diagnosis, Rival};
use crate::units::{Dimension, show_angle, show_length, show_quantity};

/// Travel at which a bent scale is stated, m; tilt at which a shift of joint centres is stated, rad.
const TRAVEL: f64 = 0.01;
const TILT: f64 = TAU / 360.0;

/// A cause with the words for its first value and its place.
struct Told<'a> {
    joints: &'a [String],
    c: &'a Cause,
    /// The first value.
    value: f64,
    /// Its size.
    size: String,
    /// The leg as the beginning of a sentence.
    part: String,
    /// `grow` or `shrink`.
    grow: &'static str,
    /// `more` or `less`.
    less: &'static str,
    /// The direction of a leg.
    longer: &'static str,
    /// ` at data row 40`.
    from: String,
}

/// What was found and what to look at, with the identified values.
fn meaning(joints: &[String], c: &Cause) -> String {
    let Place { part, moves: [shorter, longer] } = Place::of(joints, c.leg);
    let first = c.parameters.first();
    let value = first.map_or(0.0, |p| p.value);
    let size = first.map_or_else(String::new, |p| show_quantity(p.value.abs(), p.dimension));
    let from = c.row.map_or_else(String::new, |row| format!(" at data row {row}"));
    let [grow, less, longer] = if value < 0.0 { ["shrink", "less", shorter] } else { ["grow", "more", longer] };
    let told = Told { joints, c, value, size, part, grow, less, longer, from };
    [thermal, scales, play_and_joints, loads, time, instrument, axes]
        .iter()
        .find_map(|of| of(&told))
        .unwrap_or_else(|| own(c))
}

/// Growth with temperature.
fn thermal(told: &Told<'_>) -> Option<String> {
    let Told { c, size, part, grow, less, .. } = told;
    Some(match told.c.effect.as_str() {
        "thermal.legs.uniform" => format!(
            "All legs {grow} with their mean temperature by {size}: correct the commanded lengths for it, or use legs that \
             expand less."
        ),
        "thermal.legs.individual" => format!(
            "Each leg {grow}s with its own temperature by {size}: correct each length for it, and find what heats the \
             legs differently."
        ),
        "thermal.leg.single" => format!(
            "{part} grows with its temperature by {size} {less} than the others: look at its material or its sensor, and \
             at what warms it."
        ),
        "thermal.platform" => format!(
            "The platform {grow}s with its temperature by {size}: correct for it, or choose a material that expands less."
        ),
        "thermal.base" => format!(
            "The base {grow}s with its temperature by {size}: correct for it, or let it reach a steady temperature before \
             use."
        ),
        "thermal.gradient" => format!(
            "One side of the base is warmer than the other, and it {grow}s unevenly by {size}: shield it from the heat \
             source, or correct for the temperatures of its sensors."
        ),
        "thermal.pose" => format!(
            "The pose moves with {} by {}: add it to the look-up table.",
            c.of.as_deref().unwrap_or("a temperature"),
            both(c)
        ),
        "thermal.frame" => format!(
            "The frame of the instrument moves with {} by {}: measure reference points on the base as it changes, or keep the \
             stand at one temperature; no command can correct it.",
            c.of.as_deref().unwrap_or("a temperature"),
            both(c)
        ),
        _ => return None,
    })
}

/// Errors of the scales of the legs.
fn scales(told: &Told<'_>) -> Option<String> {
    let Told { joints, c, size, less, .. } = told;
    Some(match told.c.effect.as_str() {
        "scale.common" => format!(
            "All legs move by {size} {less} than commanded, as the tracker measures it: check the lead of the screws and the \
             scale of the tracker against a gauge."
        ),
        "scale.per_leg" => {
            let (worst, p) = largest(joints, &c.parameters);
            let less = if p < 0.0 { "less" } else { "more" };
            format!(
                "Each leg moves by a scale of its own, most of all {worst}, by {} {less} than commanded: enter the factors \
                 in the controller, or measure the leads.",
                show_quantity(p.abs(), Dimension::None)
            )
        }
        "length.quadratic" => {
            let (worst, p) = largest(joints, &c.parameters);
            let of_angles = c.parameters.iter().any(|p| p.dimension == Dimension::PerAngle);
            let (bent, travel) = match of_angles {
                true => (show_angle(p.abs() * TAU * TAU), "one turn".to_owned()),
                false => (show_length(p.abs() * TRAVEL * TRAVEL), show_length(TRAVEL)),
            };
            format!(
                "The scales of the legs are bent, most of all that of {worst}, by {bent} at {travel} from home: calibrate the \
                 encoders against a linear reference, or enter the curvature in the controller."
            )
        }
        "cyclic.pitch" => {
            let (worst, amplitude) = waves(joints, &c.parameters);
            format!(
                "The screws wobble with every turn, most of all that of {worst}, by ±{}: compensate the wave in the \
                 controller, or read the legs with linear encoders.",
                show_length(amplitude)
            )
        }
        _ => return None,
    })
}

/// Play and imperfect joints.
fn play_and_joints(told: &Told<'_>) -> Option<String> {
    let Told { joints, c, value, .. } = told;
    Some(match told.c.effect.as_str() {
        "backlash" => {
            let (worst, p) = largest(joints, &c.parameters);
            let dimension = c.parameters.first().map_or(Dimension::Length, |p| p.dimension);
            format!(
                "There is play where legs turn round, most of all {} at {worst}: approach every pose from the same side, \
                 or preload the joints.",
                show_quantity(p.abs(), dimension)
            )
        }
        "hysteresis.play" => format!(
            "Moves shorter than {} are lost in the play of the legs, most of all at {}: preload the joints, or approach \
             every pose with a long move from the same side.",
            c.of.as_deref().map_or_else(|| "the play".into(), |width| width.replace("um", " um")),
            largest(joints, &c.parameters).0
        ),
        "joint.pivot_shift" => format!(
            "The centres of the joints shift as the legs tilt, by {} at one degree: correct for the square of the tilt, and \
             do not use the model far outside of the calibrated range.",
            show_length(value.abs() * TILT * TILT)
        ),
        "joint.screw_coupling" => format!(
            "The screws turn with the legs as the platform rotates, by {} for each turn: correct the lengths for the \
             twist, or hold the screws against turning.",
            show_length(value.abs() * TAU)
        ),
        _ => return None,
    })
}

/// Gravity and payload.
fn loads(told: &Told<'_>) -> Option<String> {
    let Told { c, size, .. } = told;
    Some(match told.c.effect.as_str() {
        "compliance.gravity" => format!(
            "The legs give way by {size} under the weight of the platform, and differently at each elevation: correct for \
             the elevation, or stiffen the legs and their joints."
        ),
        "compliance.payload" => format!(
            "The legs give way by {size} under the payload: correct for its weight, or stiffen the legs and their joints."
        ),
        "sag.frame" => format!(
            "The frame between base and tracker sags with the elevation by {}: measure reference points on the base at each \
             elevation; no command can correct it.",
            both(c)
        ),
        "sag.platform" => format!(
            "The platform bends into a saddle under its own weight, by {}: stiffen it, or correct for the elevation.",
            show_length(c.parameters.iter().map(|p| p.value.powi(2)).sum::<f64>().sqrt())
        ),
        "sag.linear" => format!(
            "Structure and positioner sag with the direction of gravity by up to {}: correct with a table against the \
             elevation.",
            both(c)
        ),
        _ => return None,
    })
}

/// What changes with time alone.
fn time(told: &Told<'_>) -> Option<String> {
    let Told { c, size, part, longer, from, .. } = told;
    Some(match told.c.effect.as_str() {
        "drift.frame" => format!(
            "The tracker, or what it stands on, drifted by {} in the course of the run: let it warm up, and repeat a \
             reference pose every ten samples.",
            both(c)
        ),
        "step.frame" => format!(
            "The tracker or the target jumped by {}{from}: register it again, or split the file there.",
            both(c)
        ),
        "drift.leg" => format!(
            "{part} crept by {size} in the course of the run, towards {longer}: check its encoder and its brake, home it \
             again and repeat the run."
        ),
        "step.leg" => format!(
            "{part} jumped by {size}{from}, towards {longer}: tighten its coupling, home it, and split the file there."
        ),
        _ => return None,
    })
}

/// What only the instrument reads wrongly.
fn instrument(told: &Told<'_>) -> Option<String> {
    let c = told.c;
    let worst = c.parameters.iter().max_by(|a, b| a.value.abs().total_cmp(&b.value.abs()));
    let (axis, size) = worst.map_or_else(Default::default, |p| {
        let more = if p.value < 0.0 { "too short" } else { "too long" };
        (p.name.clone(), format!("{} {more}", show_quantity(p.value.abs(), p.dimension)))
    });
    Some(match c.effect.as_str() {
        "instrument.scale" => format!(
            "The instrument reads positions along its axes with wrong scales, {axis} most of all, by {size}: check it against \
             a known length, and its correction for the air; no command can correct it."
        ),
        "instrument.rotation_gain" => format!(
            "The instrument reads angles with wrong factors, {axis} most of all, by {size}: check it against a known angle; \
             no command can correct it."
        ),
        "instrument.skew" => format!(
            "The axes of the instrument are not at right angles, by {}: square them, or measure a known body in several \
             attitudes; no command can correct it.",
            both(c)
        ),
        _ => return None,
    })
}

/// Coordinates of a positioner.
fn axes(told: &Told<'_>) -> Option<String> {
    let Told { c, size, part, less, .. } = told;
    Some(match c.effect.as_str() {
        "axis.scale" => format!(
            "{part} moves by {size} {less} than commanded: compare its scale and that of the instrument with a gauge, and \
             enter the factor in the controller."
        ),
        "axis.cyclic" => format!(
            "{part} wobbles with every turn of its screw, by ±{}: compensate the wave in the controller, or read the axis \
             with a linear encoder.",
            show_quantity(
                c.parameters.iter().map(|p| p.value.powi(2)).sum::<f64>().sqrt(),
                c.parameters.first().map_or(Dimension::Length, |p| p.dimension)
            )
        ),
        "axis.backlash" => format!(
            "{part} has a play of {size} where it turns round: approach every pose from the same side along it, or preload \
             it."
        ),
        _ => return None,
    })
}

/// The sentence of an effect that is not in the catalogue of this crate.
fn own(c: &Cause) -> String {
    let mut letters = c.cause.chars();
    let first: String = letters.next().map(|l| l.to_uppercase().collect()).unwrap_or_default();
    let value = |p: &CauseParameter| format!("{} {}", p.name, show_quantity(p.value, p.dimension));
    let values: Vec<String> = c.parameters.iter().take(3).map(value).collect();
    format!("{first}{} ({}): {}.", letters.as_str(), values.join(", "), c.remedy)
}

/// What a leg is called, and its two directions.
struct Place {
    part: String,
    moves: [&'static str; 2],
}

impl Place {
    fn of(joints: &[String], leg: Option<usize>) -> Self {
        let Some(leg) = leg else { return Self { part: "One leg".into(), moves: ["shorter", "longer"] } };
        match joints.get(leg).and_then(|name| name.strip_prefix("cmd_")) {
            Some(coordinate) => Self { part: format!("The coordinate {coordinate}"), moves: ["minus", "plus"] },
            None => Self { part: format!("Leg {}", leg + 1), moves: ["shorter", "longer"] },
        }
    }
}

/// Lengths and angles of a motion, each as the largest of its kind: `12.3 um and 4.5 arcsec`.
fn both(c: &Cause) -> String {
    let largest = |wanted: &[Dimension]| {
        let own = c.parameters.iter().filter(|p| wanted.contains(&p.dimension));
        own.max_by(|a, b| a.value.abs().total_cmp(&b.value.abs()))
    };
    let kinds: [&[Dimension]; 2] =
        [&[Dimension::Length, Dimension::LengthPerKelvin], &[Dimension::Angle, Dimension::AnglePerKelvin]];
    let shown = kinds.into_iter().filter_map(largest).map(|p| show_quantity(p.value.abs(), p.dimension));
    shown.collect::<Vec<_>>().join(" and ")
}

/// The leg with the largest value, and that value.
fn largest(joints: &[String], parameters: &[CauseParameter]) -> (String, f64) {
    let all = parameters.iter().enumerate();
    let (leg, value) =
        all.map(|(k, p)| (k, p.value)).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or((0, 0.0));
    (called(joints, leg), value)
}

/// The leg whose wave is the largest, and its amplitude: sines of all legs, then cosines.
fn waves(joints: &[String], parameters: &[CauseParameter]) -> (String, f64) {
    let (sines, cosines) = parameters.split_at(parameters.len() / 2);
    let amplitudes = sines.iter().zip(cosines).map(|(s, c)| s.value.hypot(c.value)).enumerate();
    let (leg, amplitude) = amplitudes.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0));
    (called(joints, leg), amplitude)
}

fn called(joints: &[String], leg: usize) -> String {
    match joints.get(leg).filter(|name| !name.starts_with("leg")) {
        Some(name) => name.clone(),
        None => format!("leg {}", leg + 1),
    }
}

/// All named causes in their sentences, with what else it could be.
pub(in crate::report) fn meanings(d: &Diagnosis) -> Vec<String> {
    let one = |c: &Cause| {
        let sentence = meaning(&d.joints, c);
        match c.tied_with.is_empty() {
            true => sentence,
            false => {
                let mut rivals: Vec<String> = c.tied_with.iter().map(Rival::label).collect();
                rivals.dedup();
                format!("It looks as follows, but could also be {}: {sentence}", rivals.join(" or "))
            }
        }
    };
    d.causes.iter().map(one).collect()
}
