//! Effects that only the instrument sees, and those of single axes, against numbers by hand.

use crate::common::effects::{hexapod, positioner, read, with_effects};
use paracal::conditions::Conditions;
use paracal::effect::{Compensator, EffectContext, seen};
use paracal::files::{EffectEntry, Machine};
use paracal::nalgebra::{Rotation3, Vector3};
use paracal::pose::Pose;

const REFERENCE: &str = "reference_temperature_degC = 20.0\n";

fn entry(name: &str, parameters: &[(&str, f64)]) -> EffectEntry {
    let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    EffectEntry { name: name.into(), parameters, ..EffectEntry::default() }
}

/// Where the instrument of a machine sees a pose.
fn seen_by(machine: &Machine, pose: &Pose, at: &Conditions) -> Pose {
    let context = EffectContext::new(machine.plain(), machine.environment());
    seen(machine.instrument(), &context, &[0.8; 6], pose, at)
}

fn turned(rx: f64, ry: f64, rz: f64) -> Rotation3<f64> {
    let about = |axis: Vector3<f64>, angle: f64| Rotation3::new(axis * angle);
    about(Vector3::z(), rz) * about(Vector3::y(), ry) * about(Vector3::x(), rx)
}

fn close(found: f64, wanted: f64, within: f64) {
    assert!((found - wanted).abs() < within, "{found} instead of {wanted}");
}

#[test]
fn positions_are_read_with_a_factor_for_each_axis_at_the_point_that_is_read() {
    let scale = entry("instrument.scale", &[("x", 2e-4), ("y", -1e-4), ("z", 3e-4)]);
    for pivot in ["", "pivot = [100.0, -50.0, 20.0]\n"] {
        let machine = with_effects(&hexapod(&format!("{REFERENCE}{pivot}"), ""), std::slice::from_ref(&scale));
        let pose = Pose { position: Vector3::new(0.02, -0.03, 0.5), rotation: turned(0.05, -0.1, 0.2) };
        let at = if pivot.is_empty() { Vector3::zeros() } else { Vector3::new(0.1, -0.05, 0.02) };
        let read = |pose: &Pose| pose.rotation * at + pose.position;
        let (before, after) = (read(&pose), read(&seen_by(&machine, &pose, &Conditions::unknown())));
        for (k, factor) in [2e-4, -1e-4, 3e-4].into_iter().enumerate() {
            close(after[k], before[k] * (1.0 + factor), 1e-12);
        }
    }
}

#[test]
fn angles_are_read_with_a_factor_about_those_of_home() {
    let gain = entry("instrument.rotation_gain", &[("rx", 3e-4), ("ry", 0.0), ("rz", -2e-4)]);
    let machine = with_effects(&hexapod(REFERENCE, ""), &[gain]);
    let (rx, ry, rz) = (0.07, -0.12, 0.18);
    let pose = Pose { position: Vector3::new(0.01, 0.02, 0.47), rotation: turned(rx, ry, rz) };
    let found = seen_by(&machine, &pose, &Conditions::unknown());
    let wanted = turned(rx * (1.0 + 3e-4), ry, rz * (1.0 - 2e-4));
    assert!(found.rotation.angle_to(&wanted) < 1e-9, "{}", found.rotation.angle_to(&wanted));
    assert!((found.position - pose.position).norm() < 1e-15);
}

#[test]
fn axes_that_are_not_square_mix_coordinates() {
    let skew = entry("instrument.skew", &[("xy", 1e-4), ("xz", 2e-4), ("yz", -3e-4)]);
    let machine = with_effects(&hexapod(REFERENCE, ""), &[skew]);
    let pose = Pose { position: Vector3::new(0.02, -0.03, 0.5), rotation: turned(0.0, 0.1, 0.0) };
    let found = seen_by(&machine, &pose, &Conditions::unknown()).position - pose.position;
    close(found.x, 1e-4 * -0.03 + 2e-4 * 0.5, 1e-15);
    close(found.y, -3e-4 * 0.5, 1e-15);
    close(found.z, 0.0, 1e-15);
}

#[test]
fn a_frame_follows_its_temperature_and_no_command_compensates_it() {
    let names = ["x", "y", "z", "rx", "ry", "rz"];
    let values = [1e-6, -2e-6, 8e-6, 0.0, 0.0, 1e-6];
    let frame = EffectEntry {
        of: Some("temp_room".into()),
        ..entry("thermal.frame", &names.map(|n| (n, values[names.iter().position(|m| *m == n).unwrap()])))
    };
    let machine = with_effects(&hexapod(REFERENCE, ""), &[frame]);
    let mut at = Conditions::unknown();
    at.covariates.insert("temp_room".into(), 23.0);
    let pose = Pose { position: Vector3::new(0.1, 0.2, 0.5), rotation: Rotation3::identity() };
    let found = seen_by(&machine, &pose, &at).position - pose.position;
    // 3 K; a turn about z of the origin carries (0.1, 0.2) along (-0.2, 0.1).
    close(found.x, 3.0 * (1e-6 - 0.2 * 1e-6), 1e-15);
    close(found.y, 3.0 * (-2e-6 + 0.1 * 1e-6), 1e-15);
    close(found.z, 3.0 * 8e-6, 1e-15);
    let plain = machine.plain();
    let home = plain.home();
    let mut commands = Compensator::new(plain, machine.environment(), &machine.effects(), false).unwrap();
    let joints = commands.command(&home, &at).unwrap().joints;
    let own = plain.inverse(plain.values(), &home, &at).unwrap();
    assert!(joints.iter().zip(&own).all(|(a, b)| (a - b).abs() < 1e-12));
    assert_eq!(commands.left_out().len(), 1);
}

#[test]
fn single_axes_of_a_positioner_stretch_wobble_and_have_play() {
    let text = positioner(REFERENCE, "\n[actuator]\nscrew_pitch = 5.0\n");
    let plain = read(&text);
    let joints = [0.012, -0.004, 0.003, 0.01, -0.02, 0.03];
    let mut states = vec![Conditions::unknown(); 2];
    Conditions::put_in_run(&mut states, vec![vec![0.02, -0.03, 0.0, 0.05, -0.05, 0.0], joints.to_vec()], None);
    let at = states.swap_remove(1);
    let moved = |effect: EffectEntry| {
        let machine = with_effects(&text, &[effect]);
        let forward = |m: &dyn paracal::mechanism::Mechanism| m.forward(m.values(), &joints, &at, &m.home()).unwrap();
        let (a, b) = (forward(machine.mechanism.as_ref()), forward(plain.mechanism.as_ref()));
        let (a, b) = (machine.convention.coordinates(&a), machine.convention.coordinates(&b));
        let differences: [f64; 6] = std::array::from_fn(|k| a[k] - b[k]);
        differences
    };
    let of = |leg: usize, effect: EffectEntry| EffectEntry { leg: Some(leg), ..effect };
    let wave = (std::f64::consts::TAU * 0.012 / 0.005).sin_cos();
    for (effect, k, wanted) in [
        (of(2, entry("axis.scale", &[("scale", 1e-3)])), 1, -4e-6),
        (of(5, entry("axis.scale", &[("scale", 1e-3)])), 4, -2e-5),
        (of(1, entry("axis.cyclic", &[("sin", 3e-6), ("cos", -1e-6)])), 0, 3e-6 * wave.0 - 1e-6 * wave.1),
        (of(1, entry("axis.backlash", &[("play", 4e-6)])), 0, -2e-6),
        (of(6, entry("axis.backlash", &[("play", 4e-6)])), 5, 2e-6),
    ] {
        let found = moved(effect);
        for (i, v) in found.into_iter().enumerate() {
            close(v, if i == k { wanted } else { 0.0 }, 1e-12);
        }
    }
}

#[test]
fn effects_of_joints_are_none_of_a_positioner_and_the_other_way_round() {
    let refused = |text: &str, entry: &EffectEntry| {
        let mut document = read(text).document().clone();
        document.effects.push(entry.clone());
        Machine::from_document(document, "m.toml".as_ref()).unwrap_err().to_string()
    };
    let scale = entry("instrument.scale", &[("x", 0.0), ("y", 0.0), ("z", 0.0)]);
    assert!(refused(&positioner("", ""), &scale).contains("joints other than"));
    let axis = EffectEntry { leg: Some(1), ..entry("axis.scale", &[("scale", 0.0)]) };
    assert!(refused(&hexapod("", ""), &axis).contains("type \"pose\""));
    let lag = EffectEntry { lag_s: Some(-5.0), ..entry("thermal.base", &[("expansion", 1e-5)]) };
    assert!(refused(&hexapod("", ""), &lag).contains("above zero"));
    let lag = EffectEntry { lag_s: Some(60.0), ..entry("scale.common", &[("scale", 1e-5)]) };
    assert!(refused(&hexapod("", ""), &lag).contains("does not apply"));
}
