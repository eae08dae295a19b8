//! What effects do, against differences, closed forms and numbers by hand.

use std::sync::Arc;

use crate::common::effects::{entries, hexapod, moves, pose_beside_home, positioner, read, state, with_effects};
use paracal::conditions::Conditions;
use paracal::effect::{Compensator, EffectContext, seen};
use paracal::files::{EffectEntry, Machine};
use paracal::measurement::{Dataset, Noise, PoseMeasurement, Rows, Sample};
use paracal::mechanism::{Body, Mechanism, MotionBlock};
use paracal::nalgebra::{Rotation3, Unit, Vector3, Vector6};
use paracal::pose::{Pose, PoseConvention};

const REFERENCE: &str = "reference_temperature_degC = 20.0\n";

fn entry(name: &str, parameters: &[(&str, f64)]) -> EffectEntry {
    let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    EffectEntry { name: name.into(), parameters, ..EffectEntry::default() }
}

fn of_leg(leg: usize, entry: EffectEntry) -> EffectEntry {
    EffectEntry { leg: Some(leg), ..entry }
}

/// The mechanism of Table 5 with one effect.
fn machine(effect: EffectEntry) -> Machine {
    with_effects(&hexapod(REFERENCE, ""), &[effect])
}

fn unknown() -> Conditions {
    Conditions::unknown()
}

fn joints_at(machine: &Machine, pose: &Pose) -> Vec<f64> {
    let m = machine.plain();
    m.inverse(m.values(), pose, &unknown()).unwrap()
}

fn forward(m: &dyn Mechanism, joints: &[f64], at: &Conditions) -> Pose {
    m.forward(m.values(), joints, at, &m.home()).unwrap()
}

/// Coordinates of the true joints less those commanded, from the inverse kinematics of a pose.
fn delta(machine: &Machine, pose: &Pose, at: &Conditions) -> Vec<f64> {
    let m = machine.mechanism.as_ref();
    let commanded = m.inverse(m.values(), pose, at).unwrap();
    joints_at(machine, pose).iter().zip(commanded).map(|(t, c)| t - c).collect()
}

#[track_caller]
fn close(found: &[f64], wanted: &[f64], within: f64) {
    assert_eq!(found.len(), wanted.len());
    for (a, b) in found.iter().zip(wanted) {
        assert!((a - b).abs() <= within, "{found:?} instead of {wanted:?}");
    }
}

#[test]
fn motions_per_parameter_are_those_of_forward_kinematics() {
    for text in [hexapod(REFERENCE, ""), positioner(REFERENCE, "")] {
        let plain = read(&text);
        let pose = pose_beside_home(&plain);
        let joints = joints_at(&plain, &pose);
        let at = state(&joints);
        let mut tested = 0;
        for entry in entries(&plain).into_iter().filter(moves) {
            let sizes: Vec<f64> = with_effects(&text, std::slice::from_ref(&entry)).effects()[0].values.clone();
            // At zero, where nothing that is left out of the derivatives is there.
            let zero = EffectEntry { parameters: entry.parameters.keys().map(|k| (k.clone(), 0.0)).collect(), ..entry };
            let machine = with_effects(&text, std::slice::from_ref(&zero));
            let m = machine.mechanism.as_ref();
            let here = forward(m, &joints, &at);
            let mut block = MotionBlock::sized_for(m);
            m.motion_block(m.values(), &joints, &here, &at, &mut block).unwrap();
            let first = plain.mechanism.parameters().len();
            for (k, size) in sizes.iter().enumerate() {
                let step = 0.1 * size.abs().max(1e-6);
                let motion = |by: f64| {
                    let mut c = m.values().to_vec();
                    c[first + k] += by;
                    here.motion_to(&m.forward(&c, &joints, &at, &here).unwrap())
                };
                let numeric = (motion(step) - motion(-step)) / (2.0 * step);
                let analytic = block.parameters.column(first + k);
                let error = (numeric - analytic).norm();
                let allowed = 1e-5 * analytic.norm() + 1e-11 / step;
                assert!(error < allowed, "{}, {k}: {analytic} is {error:e} off", zero.name);
                assert!(analytic.norm() > 0.0, "{}, {k} does nothing", zero.name);
            }
            tested += 1;
        }
        assert!(tested >= 3, "{tested}");
    }
}

#[test]
fn closures_of_extended_mechanisms_agree_with_their_forward_kinematics() {
    let text = hexapod(REFERENCE, "");
    let plain = read(&text);
    let all: Vec<EffectEntry> = entries(&plain).into_iter().filter(moves).collect();
    let machine = with_effects(&text, &all);
    let m = machine.mechanism.as_ref();
    let joints = joints_at(&plain, &pose_beside_home(&plain));
    let at = state(&joints);
    let pose = forward(m, &joints, &at);
    let mut rows = paracal::mechanism::Linearization::sized_for(m);
    m.linearize(m.values(), &joints, &pose, &at, &mut rows);
    assert!(rows.residual.amax() < 1e-12, "{:e}", rows.residual.amax());
    let back = m.inverse(m.values(), &pose, &at).unwrap();
    close(&back, &joints, 1e-12);
}

#[test]
fn readings_per_parameter_are_those_of_the_instrument() {
    let text = hexapod(REFERENCE, "");
    let plain = read(&text);
    let pose = pose_beside_home(&plain);
    let joints = joints_at(&plain, &pose);
    let at = state(&joints);
    let model = PoseMeasurement::full(PoseConvention::default(), &[pose], 1e-6, 1e-6);
    let sample = Sample { joints: joints.clone(), conditions: at.clone(), ..Sample::default() };
    let data = Dataset::new(vec![sample], Arc::new(model), Noise::stated(1e-6, 1e-6));
    let seen_only: Vec<EffectEntry> = entries(&plain).into_iter().filter(|e| !moves(e)).collect();
    assert_eq!(seen_only.len(), 7);
    for entry in seen_only {
        let machine = with_effects(&text, &[entry]);
        let effects = machine.instrument();
        let wrapped =
            paracal::effect::WithInstrumentEffects::wrap(&data, machine.plain(), machine.environment(), effects)
                .unwrap();
        let own = wrapped.model().nuisance_parameters().len();
        let evaluate = |values: &[f64]| {
            let mut rows = Rows::sized(6, own);
            wrapped.evaluate(0, &pose, values, &mut rows);
            rows
        };
        let values = effects[0].values.clone();
        let rows = evaluate(&values);
        for k in 0..own {
            let at = |by: f64| {
                let mut values = values.clone();
                values[k] += by;
                evaluate(&values).residual
            };
            let numeric = (at(1e-4) - at(-1e-4)) / 2e-4;
            assert!((numeric - rows.own.column(k)).norm() < 1e-4, "{}, {k}", effects[0].label());
        }
        // The same as a simulation sees.
        let context = EffectContext::new(machine.plain(), machine.environment());
        let moved = pose.motion_to(&seen(effects, &context, &joints, &pose, &at));
        assert!(moved.amax() > 1e-6 && (moved.fixed_rows::<3>(0) - rows.residual.fixed_rows::<3>(0)).norm() < 1e-12);
    }
}

#[test]
fn a_machine_that_grows_in_all_its_parts_is_similar_to_itself() {
    let one = |name| entry(name, &[("expansion", 1e-5)]);
    let parts = [one("thermal.legs.individual"), one("thermal.platform"), one("thermal.base")];
    let machine = with_effects(&hexapod(REFERENCE, ""), &parts);
    let pose = pose_beside_home(&machine);
    let joints = joints_at(&machine, &pose);
    let mut at = unknown();
    for name in
        ["temp_platform", "temp_base", "temp_leg1", "temp_leg2", "temp_leg3", "temp_leg4", "temp_leg5", "temp_leg6"]
    {
        at.covariates.insert(name.into(), 27.0);
    }
    let grown = forward(machine.mechanism.as_ref(), &joints, &at);
    let wanted = Pose { position: pose.position * (1.0 + 7e-5), ..pose };
    assert!(wanted.motion_to(&grown).amax() < 1e-13, "{}", wanted.motion_to(&grown));
}

#[test]
fn legs_grow_with_their_temperatures() {
    let pose = pose_beside_home(&read(&hexapod("", "")));
    let at = state(&[0.8; 6]);
    // Leg k has 20 °C + 0.7 k; the mean is 2.45 above the reference.
    let uniform = machine(entry("thermal.legs.uniform", &[("expansion", 1.2e-5)]));
    let lengths = joints_at(&uniform, &pose);
    let wanted = |t: &dyn Fn(usize) -> f64| -> Vec<f64> {
        // The commanded length is the true one over 1 + α ΔT.
        (0..6).map(|k| lengths[k] - lengths[k] / (1.0 + 1.2e-5 * t(k))).collect()
    };
    close(&delta(&uniform, &pose, &at), &wanted(&|_| 2.45), 1e-15);
    let individual = machine(entry("thermal.legs.individual", &[("expansion", 1.2e-5)]));
    close(&delta(&individual, &pose, &at), &wanted(&|k| 0.7 * (k + 1) as f64), 1e-15);
    let single = machine(of_leg(4, entry("thermal.leg.single", &[("expansion", 1.2e-5)])));
    close(&delta(&single, &pose, &at), &wanted(&|k| if k == 3 { 2.8 } else { 0.0 }), 1e-15);
}

#[test]
fn a_base_with_a_gradient_bends_along_it() {
    // Sensors read 20 + 2 + 3 x/m + 1 y/m; a point b moves by α (2 + ½ (3 bx + by)) b.
    let flat = hexapod(REFERENCE, "").replace("-1200.0, 50.0]", "-1200.0, 0.0]");
    let machine = with_effects(&flat, &[entry("thermal.gradient", &[("expansion", 1e-5)])]);
    let mut at = unknown();
    for (name, x, y) in [("temp_base1", 1.4, 0.0), ("temp_base2", -0.7, 1.2), ("temp_base3", -0.7, -1.2)] {
        at.covariates.insert(name.into(), 22.0 + 3.0 * x + y);
    }
    let m = machine.plain();
    let pose = pose_beside_home(&machine);
    let commanded = machine.mechanism.inverse(machine.mechanism.values(), &pose, &at).unwrap();
    let (a, b) = (Body::Platform.points(m, m.values()), Body::Base.points(m, m.values()));
    let wanted: Vec<f64> = (0..6)
        .map(|k| {
            let b = b[k].1 * (1.0 + 1e-5 * (2.0 + 0.5 * (3.0 * b[k].1.x + b[k].1.y)));
            (pose.place(&a[k].1) - b).norm()
        })
        .collect();
    close(&commanded, &wanted, 1e-13);
}

#[test]
fn scale_curvature_and_waves_are_those_of_the_length() {
    let all =
        |stem: &str, value: f64| -> Vec<(String, f64)> { (1..=6).map(|k| (format!("{stem}{k}"), value)).collect() };
    let listed = |name: &str, parameters: Vec<(String, f64)>| EffectEntry {
        name: name.into(),
        parameters: parameters.into_iter().collect(),
        ..EffectEntry::default()
    };
    // Home is where all legs are commanded to 800 mm.
    let commanded = [0.8, 0.81, 0.79, 0.805, 0.8125, 0.7901];
    let home = |machine: &Machine| machine.environment().home_joints.clone().unwrap();
    let check = |effect: EffectEntry, wanted: &dyn Fn(f64, f64) -> f64| {
        let machine = machine(effect);
        close(&home(&machine), &[0.8; 6], 1e-9);
        let went = forward(machine.mechanism.as_ref(), &commanded, &unknown());
        let truth = joints_at(&machine, &went);
        let found: Vec<f64> = truth.iter().zip(commanded).map(|(t, c)| t - c).collect();
        let wanted: Vec<f64> = commanded.iter().zip(home(&machine)).map(|(c, h)| wanted(*c, h)).collect();
        close(&found, &wanted, 1e-13);
    };
    check(entry("scale.common", &[("scale", 1e-3)]), &|l, h| 1e-3 * (l - h));
    check(listed("scale.per_leg", all("scale", -2e-3)), &|l, h| -2e-3 * (l - h));
    check(listed("length.quadratic", all("curvature", 0.05)), &|l, h| 0.05 * (l - h).powi(2));
    let mut waves = all("sin", 4e-6);
    waves.extend(all("cos", -3e-6));
    let pitch = 5e-3;
    let wave = |l: f64, _: f64| {
        let turn = std::f64::consts::TAU * l / pitch;
        4e-6 * turn.sin() - 3e-6 * turn.cos()
    };
    check(listed("cyclic.pitch", waves), &wave);
}

#[test]
fn play_follows_the_commands_of_the_run() {
    let six = |stem: &str, value: f64| (1..=6).map(|k| (format!("{stem}{k}"), value)).collect();
    let backlash = EffectEntry { name: "backlash".into(), parameters: six("play", 1e-5), ..EffectEntry::default() };
    let machine_with_backlash = machine(backlash);
    let true_joints = |machine: &Machine, joints: &[f64], at: &Conditions| {
        joints_at(machine, &forward(machine.mechanism.as_ref(), joints, at))
    };
    let mut at = unknown();
    at.previous_joints = Some(vec![0.799, 0.801, 0.8, 0.799, 0.801, 0.8]);
    let found = true_joints(&machine_with_backlash, &[0.8; 6], &at);
    close(&found, &[0.8 + 5e-6, 0.8 - 5e-6, 0.8, 0.8 + 5e-6, 0.8 - 5e-6, 0.8], 1e-13);
    // An ideal play of 20 µm from home at 0.8 m: up by 30 (follows to 20), down by 15 (stays), down by 25 (follows to 0).
    let play = EffectEntry {
        name: "hysteresis.play".into(),
        of: Some("20um".into()),
        parameters: six("part", 1.0),
        ..EffectEntry::default()
    };
    let machine = machine(play);
    let home = machine.environment().home_joints.clone().unwrap();
    let at_home = |by: f64| -> Vec<f64> { home.iter().map(|h| h + by).collect() };
    let rows = vec![at_home(30e-6), at_home(15e-6), at_home(-10e-6)];
    let mut states = vec![unknown(); 3];
    Conditions::put_in_run(&mut states, rows.clone(), Some(&home));
    for ((joints, at), wanted) in rows.iter().zip(&states).zip([20e-6, 20e-6, 0.0]) {
        close(&true_joints(&machine, joints, at), &at_home(wanted), 1e-13);
    }
}

#[test]
fn a_leg_that_tilts_or_twists_by_a_known_angle() {
    let machine = machine(entry("joint.pivot_shift", &[("shift", 0.02)]));
    let m = machine.plain();
    let (a, b) = (Body::Platform.points(m, m.values())[0].1, Body::Base.points(m, m.values())[0].1);
    let home = m.home();
    let along = (home.place(&a) - b).normalize();
    // The whole platform turned about an axis through the base point of leg 1, which keeps its length.
    let turned = |axis: Vector3<f64>, angle: f64| {
        let turn = Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle);
        Pose { position: b + turn * (home.position - b), rotation: turn * home.rotation }
    };
    let across = along.cross(&Vector3::z());
    let tilted = delta(&machine, &turned(across, 0.03), &unknown());
    assert!((tilted[0] - 0.02 * 0.03 * 0.03).abs() < 1e-12, "{tilted:?}");
    let twisted = delta(&machine, &turned(along, 0.03), &unknown());
    assert!(twisted[0].abs() < 1e-12, "{twisted:?}");
    let lead = with_effects(&hexapod("", ""), &[entry("joint.screw_coupling", &[("lead", 8e-4)])]);
    let twisted = delta(&lead, &turned(along, 0.03), &unknown());
    assert!((twisted[0] - 8e-4 * 0.03).abs() < 1e-12, "{twisted:?}");
    let tilted = delta(&lead, &turned(across, 0.03), &unknown());
    assert!(tilted[0].abs() < 1e-12, "{tilted:?}");
}

#[test]
fn a_symmetric_mechanism_sinks_under_its_weight_by_the_closed_form() {
    // Legs of stiffness k that rise by u_z per length carry a weight on the axis with z stiffness k Σ u_z².
    let compliance = 2e-8;
    let by_mass = machine(entry("compliance.gravity", &[("compliance", compliance)]));
    let m = by_mass.plain();
    let (a, b, home) = (Body::Platform.points(m, m.values()), Body::Base.points(m, m.values()), m.home());
    let rise: f64 = (0..6).map(|k| ((home.place(&a[k].1) - b[k].1).normalize().z).powi(2)).sum();
    let mut at = unknown();
    at.gravity = Some(-Vector3::z());
    let moved = |machine: &Machine, at: &Conditions| {
        home.motion_to(&forward(machine.mechanism.as_ref(), &joints_at(machine, &home), at))
    };
    let sunk = moved(&by_mass, &at);
    let wanted = -500.0 * 9.81 * compliance / rise;
    // The geometry is stated to 1 µm and the force is taken at the unloaded pose.
    assert!((sunk.z / wanted - 1.0).abs() < 2e-3, "{} instead of {wanted}", sunk.z);
    assert!(sunk.x.abs() + sunk.y.abs() + sunk.fixed_rows::<3>(3).norm() < 1e-3 * wanted.abs(), "{sunk}");
    // A payload of 80 kg off the axis sinks as far and tilts towards it, away from (20, -30) mm.
    let by_payload = machine(entry("compliance.payload", &[("compliance", compliance)]));
    at.covariates.insert("payload".into(), 80.0);
    let sunk = moved(&by_payload, &at);
    assert!((sunk.z / (wanted * 80.0 / 500.0) - 1.0).abs() < 2e-3);
    assert!(sunk[3] > 0.0 && sunk[4] > 0.0, "{sunk}");
}

#[test]
fn pose_space_moves_by_what_is_stated() {
    let parameters: Vec<(String, f64)> = ["x", "y", "z", "rx", "ry", "rz"]
        .iter()
        .enumerate()
        .flat_map(|(k, row)| (0..3).map(move |g| (format!("{row}_g{}", ["x", "y", "z"][g]), 1e-5 * (3 * k + g) as f64)))
        .collect();
    let sag = EffectEntry {
        name: "sag.linear".into(),
        parameters: parameters.into_iter().collect(),
        ..EffectEntry::default()
    };
    let names = ["x", "y", "z", "rx", "ry", "rz"];
    let thermal = EffectEntry {
        of: Some("temp_mount".into()),
        ..entry("thermal.pose", &names.map(|n| (n, if n == "y" { 2e-6 } else { 0.0 })))
    };
    let machine = with_effects(&positioner(REFERENCE, ""), &[sag, thermal]);
    let mut at = unknown();
    at.covariates.insert("temp_mount".into(), 25.0);
    at.gravity = Some(Vector3::new(0.6, 0.0, -0.8));
    let went = machine.convention.coordinates(&forward(machine.mechanism.as_ref(), &[0.0; 6], &at));
    let wanted: Vec<f64> = (0..6)
        .map(|k| {
            let row = 3.0 * k as f64;
            1e-5 * (0.6 * row - 0.8 * (row + 2.0)) + if k == 1 { 2e-6 * 5.0 } else { 0.0 }
        })
        .collect();
    close(&went, &wanted, 1e-15);
}

#[test]
fn drifts_steps_and_sags_of_the_instrument() {
    let six = ["x", "y", "z", "rx", "ry", "rz"];
    let rigid = |name: &str| {
        entry(
            name,
            &six.map(|n| {
                (
                    n,
                    if n == "z" {
                        4e-6
                    } else if n == "rz" {
                        2e-6
                    } else {
                        0.0
                    },
                )
            }),
        )
    };
    let pose = Pose { position: Vector3::new(1.0, 0.0, 0.5), ..Pose::identity() };
    let mut states = vec![unknown(); 5];
    Conditions::put_in_run(&mut states, vec![vec![0.8; 6]; 5], None);
    let motion = |effect: EffectEntry, at: &Conditions| {
        let machine = machine(effect);
        let context = EffectContext::new(machine.plain(), machine.environment());
        pose.motion_to(&seen(machine.instrument(), &context, &[0.8; 6], &pose, at))
    };
    // A turn about z moves a point at x = 1 m along y.
    let drift = motion(rigid("drift.frame"), &states[2]);
    assert!((drift - Vector6::new(0.0, 1e-6, 2e-6, 0.0, 0.0, 1e-6)).norm() < 1e-12, "{drift}");
    let step = |row: usize| motion(EffectEntry { row: Some(3), ..rigid("step.frame") }, &states[row]);
    assert_eq!(step(2), Vector6::zeros());
    assert!((step(3) - Vector6::new(0.0, 2e-6, 4e-6, 0.0, 0.0, 2e-6)).norm() < 1e-12);
    let mut at = unknown();
    at.gravity = Some(Vector3::x());
    // ẑ × x̂ = ŷ: the tilt turns about y and moves a point at x = 1 m by -1 m × tilt along z, and at z = 0.5 m along x.
    let sag = motion(entry("sag.frame", &[("shift", 3e-6), ("tilt", 1e-6)]), &at);
    assert!((sag - Vector6::new(3.5e-6, 0.0, -1e-6, 0.0, 1e-6, 0.0)).norm() < 1e-12, "{sag}");
}

#[test]
fn commands_of_every_effect_lead_to_the_wanted_poses() {
    for text in [hexapod(REFERENCE, ""), positioner(REFERENCE, "")] {
        let plain = read(&text);
        let targets: Vec<Pose> = (0..4)
            .map(|k| {
                let by = 1e-3 * (k as f64 - 1.4);
                plain.mechanism.home().moved(&Vector6::new(2.0 * by, -by, by, by, -2.0 * by, 1.5 * by))
            })
            .collect();
        for entry in entries(&plain).into_iter().filter(moves) {
            let machine = with_effects(&text, std::slice::from_ref(&entry));
            let mut compensator =
                Compensator::new(machine.plain(), machine.environment(), &machine.effects(), false).unwrap();
            if entry.name.starts_with("drift.") || entry.name.starts_with("step.") {
                assert_eq!((compensator.left_out().len(), compensator.compensated().count()), (1, 0));
                continue;
            }
            let mut joints = Vec::new();
            for target in &targets {
                let found = compensator.command(target, &state(&[0.8; 6])).unwrap();
                assert!(found.lacking.is_empty() && found.outside.is_empty(), "{found:?}");
                joints.push(found.joints);
            }
            let mut states = vec![state(&[0.8; 6]); targets.len()];
            Conditions::put_in_run(&mut states, joints.clone(), machine.environment().home_joints.as_deref());
            for ((target, joints), at) in targets.iter().zip(&joints).zip(&states) {
                let went = forward(machine.mechanism.as_ref(), joints, at);
                let error = target.motion_to(&went).amax();
                assert!(error < 1e-10, "{}: {error:e}", entry.name);
            }
        }
    }
}

#[test]
fn what_only_the_instrument_sees_is_compensated_on_demand() {
    let machine = machine(entry("sag.frame", &[("shift", 3e-4), ("tilt", 2e-4)]));
    let mut at = unknown();
    at.gravity = Some(Vector3::new(0.6, 0.0, -0.8));
    let target = pose_beside_home(&machine);
    let command = |as_seen: bool| {
        let mut compensator =
            Compensator::new(machine.plain(), machine.environment(), &machine.effects(), as_seen).unwrap();
        assert_eq!(compensator.left_out().len(), usize::from(!as_seen));
        compensator.command(&target, &at).unwrap()
    };
    close(&command(false).joints, &joints_at(&machine, &target), 0.0);
    let found = command(true);
    let went = forward(machine.plain(), &found.joints, &at);
    let context = EffectContext::new(machine.plain(), machine.environment());
    let read = seen(machine.instrument(), &context, &found.joints, &went, &at);
    assert!(target.motion_to(&read).amax() < 1e-12 && target.motion_to(&went).amax() > 1e-4);
    assert!(target.motion_to(&found.seen).amax() < 1e-12);
}

#[test]
fn a_state_that_lacks_something_leaves_the_effect_out() {
    let mut thermal = entry("thermal.legs.uniform", &[("expansion", 1e-5)]);
    thermal.range.insert("temp_legs".into(), [15.0, 25.0]);
    let machine = machine(thermal);
    let target = pose_beside_home(&machine);
    let mut compensator = Compensator::new(machine.plain(), machine.environment(), &machine.effects(), false).unwrap();
    let found = compensator.command(&target, &unknown()).unwrap();
    assert_eq!(found.lacking, [("thermal.legs.uniform".to_owned(), vec!["temp_legs".to_owned()])]);
    close(&found.joints, &joints_at(&machine, &target), 0.0);
    let mut hot = unknown();
    hot.covariates.insert("temp_legs".into(), 31.0);
    let found = compensator.command(&target, &hot).unwrap();
    let [outside] = &found.outside[..] else { panic!("{:?}", found.outside) };
    assert_eq!((outside.covariate.as_str(), outside.value, outside.range), ("temp_legs", 31.0, [15.0, 25.0]));
    assert!(found.lacking.is_empty());
}
