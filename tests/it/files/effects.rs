//! `[[effect]]`: read, written, refused, identified.

use crate::common;

use std::sync::Arc;

use crate::common::effects::{entries, hexapod, moves, pose_beside_home, positioner, read, state, with_effects};
use paracal::conditions::Conditions;
use paracal::effect::{ActiveEffect, Environment, Extended, effects_of};
use paracal::files::{EffectEntry, Machine, read_measurement};
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, PriorPolicy, calibrate, evaluate};
use paracal::measurement::{DataRow, Dataset, Frames, Noise, PoseMeasurement, Sample};
use paracal::pose::{Pose, PoseConvention};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

const REFERENCE: &str = "reference_temperature_degC = 20.0\n";

fn refusal(entry: &str) -> String {
    let text = hexapod(REFERENCE, &format!("\n[[effect]]\n{entry}\n"));
    Machine::from_text(&text, "m.toml".as_ref()).unwrap_err().to_string()
}

#[track_caller]
fn refused(entry: &str, parts: &[&str]) {
    let message = refusal(entry);
    for part in ["m.toml: effect 1"].iter().chain(parts) {
        assert!(message.contains(part), "'{part}' is not in: {message}");
    }
}

/// Where the mechanism goes in a state.
fn taken(machine: &Machine, joints: &[f64], at: &Conditions) -> Pose {
    let m = machine.mechanism.as_ref();
    m.forward(m.values(), joints, at, &m.home()).unwrap()
}

#[test]
fn every_effect_comes_back_from_its_file() {
    for text in [hexapod(REFERENCE, ""), positioner(REFERENCE, "")] {
        let plain = read(&text);
        let all = entries(&plain);
        for entry in &all {
            let machine = with_effects(&text, std::slice::from_ref(entry));
            let on_mechanism = effects_of(machine.mechanism.as_ref());
            let [found] = &machine.effects()[..] else { panic!("{}", entry.name) };
            assert_eq!((on_mechanism.len(), machine.instrument().len()), if moves(entry) { (1, 0) } else { (0, 1) });
            assert_eq!(found.effect.name(), entry.name);
            let written =
                machine.document_of(machine.mechanism.as_ref(), None, &[], &Frames::default()).unwrap().to_text();
            let again = read(&written);
            let (a, b) = (&again.effects()[0], found);
            assert_eq!((&a.at, &a.range), (&b.at, &b.range), "{written}");
            assert!(a.values.iter().zip(&b.values).all(|(a, b)| (a - b).abs() < 1e-14 * b.abs()), "{written}");
            let pose = pose_beside_home(&plain);
            let joints = plain.mechanism.inverse(plain.mechanism.values(), &pose, &Conditions::unknown()).unwrap();
            let at = state(&joints);
            let (there, here) = (taken(&machine, &joints, &at), taken(&again, &joints, &at));
            assert!(there.motion_to(&here).amax() < 1e-13, "{}", entry.name);
            let moved = pose.motion_to(&there).amax();
            assert_eq!(moved > 1e-8, moves(entry), "{} moves the platform by {moved:e}", entry.name);
        }
        // All of them at once, too.
        let machine = with_effects(&text, &all);
        assert_eq!(machine.effects().len(), all.len());
        let names: Vec<&str> = machine.mechanism.parameters().iter().map(|p| p.name.as_str()).collect();
        let mut distinct = names.clone();
        distinct.sort_unstable();
        distinct.dedup();
        assert_eq!(distinct.len(), names.len());
    }
}

#[test]
fn what_an_entry_states_is_written_word_by_word() {
    let entry = "\n[[effect]]\nname = \"drift.leg\"\nleg = 3\nparameters = { drift = 1.25e-5 }\nsigma = { drift = 2e-7 }\n\
        range = { time = [0.0, 3600.0] }\n\n[[effect]]\nname = \"thermal.legs.uniform\"\n\
        parameters = { expansion = 1.17e-5 }\nrange = { temp_legs = [12.0, 25.0] }\nreference = { temp_legs = 20.3 }\n";
    let machine = read(&hexapod("", entry));
    let text = machine.document().to_text();
    for line in entry.lines() {
        assert!(text.contains(line), "'{line}' is not in:\n{text}");
    }
    assert_eq!(machine.environment().references["temp_legs"], 20.3);
    let effects = machine.effects();
    assert_eq!((effects[0].at.leg, effects[0].values[0]), (Some(2), 1.25e-5));
    assert_eq!(effects[1].range["temp_legs"], [12.0, 25.0]);
}

#[test]
fn what_is_wrong_with_an_entry_is_named() {
    let thermal = "name = \"thermal.legs.uniform\"\n";
    refused("name = \"thermal.leg\"\n", &["`name`", "'thermal.leg' is not an effect", "thermal.leg.single"]);
    refused(thermal, &["'thermal.legs.uniform', `parameters`", "'expansion' is missing"]);
    refused(
        &format!("{thermal}parameters = {{ growth = 1e-5 }}"),
        &["'growth' is not one of its parameters", "expansion"],
    );
    refused(&format!("{thermal}parameters = {{ expansion = nan }}"), &["'expansion' is NaN", "not a finite number"]);
    let good = format!("{thermal}parameters = {{ expansion = 1e-5 }}\n");
    refused(&format!("{good}leg = 2"), &["`leg`", "does not apply to this effect"]);
    refused(&format!("{good}range = {{ temp_legs = [3.0, inf] }}"), &["`range`", "'temp_legs' is inf"]);
    refused(&format!("{good}range = {{ temp_legs = [3.0, 2.0] }}"), &["`range`", "[3, 2], which is not an interval"]);
    refused(&format!("{good}sigma = {{ alpha = 1.0 }}"), &["`sigma`", "'alpha' is not one of its parameters"]);
    refused(&format!("{good}reference = {{ temp_legs = 20.0 }}"), &["`reference`", "reference_temperature_degC"]);
    let drift = "name = \"drift.leg\"\nparameters = { drift = 1e-5 }\n";
    refused(drift, &["`leg`", "is missing", "1 to 6"]);
    refused(&format!("{drift}leg = 0"), &["there is no leg 0"]);
    refused(&format!("{drift}leg = 7"), &["there is no leg 7", "1 to 6"]);
    let step = "name = \"step.leg\"\nparameters = { step = 1e-5 }\nleg = 1\n";
    refused(step, &["`row`", "is missing", "from 0"]);
    let play: String = (1..=6).map(|k| format!("part{k} = 1.0, ")).collect();
    let play = format!("name = \"hysteresis.play\"\nparameters = {{ {} }}\n", play.trim_end_matches(", "));
    refused(&play, &["`of`", "is missing", "20um"]);
    refused(&format!("{play}of = \"wide\""), &["`of`", "'wide' is not possible", "20um"]);
    assert_eq!(read(&hexapod("", &format!("\n[[effect]]\n{play}of = \"12um\""))).effects().len(), 1);
    let linear: Vec<String> = (0..18).map(|k| format!("p{k} = 0")).collect();
    refused(
        &format!("name = \"sag.linear\"\nparameters = {{ {} }}", linear.join(", ")),
        &["needs a mechanism of type"],
    );
    let twice = format!("{good}[[effect]]\n{good}");
    let message = refusal(&twice);
    assert!(message.contains("effect 2") && message.contains("is stated twice"), "{message}");
    let pitch = hexapod("", "").replace("[actuator]\nscrew_pitch = 5.0\n", "");
    let screw = format!("{pitch}\n[[effect]]\nname = \"joint.screw_coupling\"\nparameters = {{ lead = 1e-3 }}\n");
    let message = Machine::from_text(&screw, "m.toml".as_ref()).unwrap_err().to_string();
    assert!(message.contains("effect 1") && message.contains("[actuator] screw_pitch"), "{message}");
    let two = |a: f64, b: f64| {
        let one = |name: &str, t: f64| {
            format!(
                "\n[[effect]]\nname = \"{name}\"\nparameters = {{ expansion = 1e-5 }}\nreference = {{ temp_leg1 = {t} }}\n"
            )
        };
        hexapod("", &(one("thermal.legs.individual", a) + &one("thermal.leg.single", b) + "leg = 1\n"))
    };
    read(&two(20.0, 20.0));
    let message = Machine::from_text(&two(20.0, 21.0), "m.toml".as_ref()).unwrap_err().to_string();
    assert!(message.contains("effect 2") && message.contains("state one value"), "{message}");
}

/// Poses about home, the joints that the drawing commands for them, their states, and where a truth goes.
fn campaign(machine: &Machine, truth: &Extended, count: usize) -> (Vec<Sample>, Vec<Pose>) {
    use paracal::mechanism::Mechanism;
    let plain = machine.plain();
    let workspace = common::workspace(plain, 60.0, 4.0);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let poses: Vec<Pose> = (0..count).map(|_| workspace.random(&mut rng)).collect();
    let at = Conditions::unknown();
    let joints: Vec<Vec<f64>> = poses.iter().map(|p| plain.inverse(plain.values(), p, &at).unwrap()).collect();
    let mut states: Vec<Conditions> = joints.iter().map(|j| state(j)).collect();
    for (k, state) in states.iter_mut().enumerate() {
        state.covariates.insert("temp_legs".into(), 15.0 + (7 * k % 11) as f64);
    }
    Conditions::put_in_run(&mut states, joints.clone(), None);
    let samples: Vec<Sample> = joints
        .into_iter()
        .zip(states)
        .enumerate()
        .map(|(row, (joints, conditions))| Sample { id: None, row: DataRow(row), joints, conditions })
        .collect();
    let went = |(s, p): (&Sample, &Pose)| truth.forward(truth.values(), &s.joints, &s.conditions, p).unwrap();
    let went = samples.iter().zip(&poses).map(went).collect();
    (samples, went)
}

#[test]
fn effects_are_identified_and_the_written_file_is_the_same_machine() {
    // A scale per leg measures from the joints at home: those of the drawing, also in the calibrated file.
    let scales = [1e-3, -5e-4, 8e-4, 0.0, -1.2e-3, 6e-4];
    let zeros: Vec<String> = (1..=6).map(|k| format!("scale{k} = 0.0")).collect();
    let start = format!(
        "\n[[effect]]\nname = \"scale.per_leg\"\nparameters = {{ {} }}\n\n[[effect]]\nname = \"thermal.legs.uniform\"\n\
         parameters = {{ expansion = 0.0 }}\nreference = {{ temp_legs = 18.0 }}\n",
        zeros.join(", ")
    );
    let machine = read(&hexapod("", &start));
    let mut effects = machine.effects();
    effects[0].values = scales.to_vec();
    effects[1].values = vec![1.17e-5];
    let inner = common::true_mechanism(machine.plain());
    let truth = Extended::new(inner, Arc::clone(machine.environment()), effects.clone());
    let (samples, went) = campaign(&machine, &truth, 40);
    let noise = Noise::stated(1e-6, 1e-6);
    let model = PoseMeasurement::full(PoseConvention::default(), &went, noise.position, noise.rotation);
    let data = Dataset::new(samples, Arc::new(model), noise);
    let options = CalibrationOptions { prior: PriorPolicy::None, ..CalibrationOptions::default() };
    let identifier = LevenbergMarquardt::default();
    let result = calibrate(machine.mechanism.as_ref(), &data, None, &identifier, &options).unwrap();
    assert!(result.after.position.unwrap() < 1e-9, "{:?}", result.after);
    let found = effects_of(result.mechanism.as_ref());
    for (a, b) in found.iter().zip(&effects) {
        for (a, b) in a.values.iter().zip(&b.values) {
            assert!((a - b).abs() < 1e-9, "{a:e} instead of {b:e}");
        }
    }
    let document = machine.document_of(result.mechanism.as_ref(), None, &[], &Frames::default()).unwrap();
    let again = read(&document.to_text());
    assert_eq!(again.environment().references["temp_legs"], 18.0);
    let errors = evaluate(again.mechanism.as_ref(), &[], &data).unwrap().rms();
    assert!(errors.position.unwrap() < 1e-9 && errors.rotation.unwrap() < 1e-9, "{errors:?}");
    // From the parts, as a diagnosis writes it.
    let ranged: Vec<ActiveEffect> = found
        .iter()
        .cloned()
        .map(|e| ActiveEffect { range: e.range_over(&data, machine.condition_kinds()), ..e })
        .collect();
    let environment =
        Environment { references: [("temp_legs".into(), 18.0)].into(), ..(**machine.environment()).clone() };
    let plain = paracal::effect::without_effects(result.mechanism.as_ref());
    let sigmas = vec![vec![1e-6; 6], vec![f64::NAN]];
    let document =
        machine.document_with_effects(plain, None, &Frames::default(), &ranged, &sigmas, &environment).unwrap();
    assert_eq!(document.effects[1].range["temp_legs"], [15.0, 25.0]);
    assert_eq!((document.effects[0].sigma["scale3"], document.effects[1].sigma.len()), (1e-6, 0));
    let again = read(&document.to_text());
    let errors = evaluate(again.mechanism.as_ref(), &[], &data).unwrap().rms();
    assert!(errors.position.unwrap() < 1e-9, "{errors:?}");
}

#[test]
fn references_that_no_file_states_are_the_means_of_the_data() {
    let entry = "\n[[effect]]\nname = \"thermal.legs.uniform\"\nparameters = { expansion = 1e-5 }\n";
    let mut machine = read(&hexapod("", entry));
    let hot = |t: f64| {
        let mut state = Conditions::unknown();
        state.covariates.insert("temp_legs".into(), t);
        state
    };
    let joints = vec![0.8; 6];
    let shift = |machine: &Machine, t: f64| {
        let cold = taken(machine, &joints, &Conditions::unknown());
        cold.motion_to(&taken(machine, &joints, &hot(t))).z
    };
    assert_eq!(shift(&machine, 30.0), 0.0);
    let said = machine.refer_to([hot(20.0), hot(24.0)].iter(), "d.csv");
    assert!(said.as_ref().is_some_and(|s| s.ends_with("the means of d.csv: temp_legs 22.000 degC")), "{said:?}");
    assert!(shift(&machine, 22.0).abs() < 1e-15 && shift(&machine, 23.0) > 5e-6);
    assert!(machine.refer_to([hot(50.0)].iter(), "d.csv").is_none());
    let mut stated = read(&hexapod(REFERENCE, entry));
    assert!(stated.refer_to([hot(50.0)].iter(), "d.csv").is_none());
}

#[test]
fn data_are_seen_through_the_instrument_of_the_file() {
    let entry = "\n[[effect]]\nname = \"sag.frame\"\nparameters = { shift = 1e-4, tilt = 0.0 }\n";
    let machine = read(&hexapod("", entry));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.csv");
    let legs: String = (1..=6).map(|leg| format!("leg{leg}_mm,")).collect();
    let q = machine.convention.coordinates(&machine.mechanism.home());
    let (mm, deg) = (|k: usize| 1e3 * q[k], |k: usize| q[k].to_degrees());
    let row = |el: f64, x: f64, z: f64| {
        let position = format!("{:?},{:?},{:?}", mm(0) + x, mm(1), mm(2) + z);
        format!("800,800,800,800,800,800,{position},{:?},{:?},{:?},{el}\n", deg(3), deg(4), deg(5))
    };
    // At elevation 0 gravity pulls along x, at 90 degrees along -z: 0.1 mm each.
    let rows = row(0.0, 0.1, 0.0) + &row(90.0, 0.0, -0.1);
    let text = format!("{legs}x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg,elevation_deg\n{rows}");
    std::fs::write(&path, text).unwrap();
    let read = read_measurement(&path, &machine).unwrap();
    let errors = evaluate(machine.mechanism.as_ref(), &[], &read.data).unwrap().rms();
    assert!(errors.position.unwrap() < 1e-12, "{errors:?}");
    let located = machine.instrument_with(&[2e-4, 3e-6]);
    assert_eq!(located[0].values, [2e-4, 3e-6]);
}

#[test]
fn the_side_file_of_a_urdf_has_effects_too() {
    let entry = EffectEntry {
        name: "scale.common".into(),
        parameters: [("scale".to_owned(), 1e-3)].into(),
        ..EffectEntry::default()
    };
    let machine = with_effects(&hexapod("", ""), &[entry]);
    let files = machine.to_urdf().unwrap();
    assert!(files.side_needed && files.side.contains("name = \"scale.common\""), "{}", files.side);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.urdf"), &files.robot).unwrap();
    std::fs::write(folder.path().join("m.toml"), &files.side).unwrap();
    let again = Machine::read(folder.path().join("m.urdf")).unwrap();
    assert_eq!(again.effects()[0].values, [1e-3]);
    assert_eq!(again.environment().sensors, machine.environment().sensors);
}
