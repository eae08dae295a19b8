//! The kinds from file to file: choose poses, simulate, calibrate, evaluate, compensate.

use std::path::Path;

use crate::common::bench::Bench;
use crate::common::{path, text};
use paracal::conditions::Conditions;
use paracal::conformance;
use paracal::files::{Machine, read_poses};
use paracal::mechanism::Mechanism;
use paracal::pose::Pose;
use serde_json::Value;

const KINDS: [&str; 8] = [
    "rotary-stewart",
    "rotary-delta",
    "linear-delta",
    "delta-printer",
    "six-carriages",
    "tripod-3rps",
    "cables",
    "planar-cables",
];

/// A folder with the bundled file of a kind as `m.toml`, poses, data of a mechanism with drawn errors, and that
/// mechanism.
fn simulated(kind: &str, n: usize) -> Bench {
    let bench = Bench::empty().with("m.toml", text(&format!("mechanisms/{kind}.toml")));
    let chosen = bench.json(&format!("select m.toml -n {n} --candidates 300 -o poses.csv"));
    assert!(chosen["efficiency"].as_f64().unwrap() > 0.9, "{chosen}");
    bench.done("simulate m.toml --poses poses.csv --error-sd 0.1mm -o data.csv --truth truth.toml");
    bench
}

/// Largest distance between where the platform should be and where the true mechanism goes, in the coordinates that
/// the joints control, m and rad.
fn missed(truth: &dyn Mechanism, wanted: &[Pose], joints: &[Vec<f64>]) -> f64 {
    let at = Conditions::unknown();
    let mut worst: f64 = 0.0;
    for (pose, joints) in wanted.iter().zip(joints) {
        let (a, b) = (pose.coordinates(), truth.forward(truth.values(), joints, &at, pose).unwrap().coordinates());
        let controlled = (0..6).filter(|k| truth.controlled()[*k]);
        worst = controlled.map(|k| (a[k] - b[k]).abs()).fold(worst, f64::max);
    }
    worst
}

fn joints_of(compensated: &Value) -> Vec<Vec<f64>> {
    serde_json::from_value(compensated["joints"].clone()).unwrap()
}

#[test]
fn every_kind_goes_from_poses_to_commands() {
    for kind in KINDS {
        let bench = simulated(kind, 24);
        let result = bench.json("calibrate m.toml data.csv -o calibrated.toml");
        assert_eq!(result["trusted"], true, "{kind}: {result}");
        let (before, after) = (&result["rms_before"]["position_m"], &result["rms_after"]["position_m"]);
        assert!(after.as_f64().unwrap() < 0.5 * before.as_f64().unwrap(), "{kind}: {before} -> {after}");
        // The file that was written reproduces what was printed.
        let again = bench.json("evaluate calibrated.toml data.csv");
        let same = again["rms"]["position_m"].as_f64().unwrap() / after.as_f64().unwrap();
        assert!((same - 1.0).abs() < 1e-6, "{kind}: {same}");
        // Commands of the calibrated mechanism bring the true one nearer to the poses than those of the drawing.
        let truth = Machine::read(bench.at("truth.toml")).unwrap();
        let machine = Machine::read(bench.at("m.toml")).unwrap();
        let wanted: Vec<Pose> =
            read_poses(bench.at("poses.csv"), &machine).unwrap().into_iter().map(|l| l.pose).collect();
        let joints =
            |mechanism: &str| joints_of(&bench.json(&format!("compensate {mechanism} poses.csv -o commands.csv")));
        let (better, worse) = (joints("calibrated.toml"), joints("m.toml"));
        let (better, worse) =
            (missed(truth.mechanism.as_ref(), &wanted, &better), missed(truth.mechanism.as_ref(), &wanted, &worse));
        assert!(better < 0.4 * worse, "{kind}: {worse:.1e} -> {better:.1e}");
        let seen = bench.json("inspect calibrated.toml");
        assert_eq!(seen["joints"].as_array().unwrap().len(), machine.mechanism.joints().len());
    }
}

#[test]
fn exact_data_in_a_frame_of_their_own_give_the_mechanism_back() {
    for kind in KINDS {
        let bench = simulated(kind, 30);
        let nominal = Machine::read(bench.at("m.toml")).unwrap();
        let truth = Machine::read(bench.at("truth.toml")).unwrap();
        let tracker = Pose::from_coordinates(&[4.0, -2.5, 1.0, 0.4, -0.3, 2.1]);
        let target = Pose::from_coordinates(&[0.1, 0.05, -0.08, 0.2, 0.1, -0.3]);
        let at = Conditions::unknown();
        let (n, t) = (nominal.mechanism.as_ref(), truth.mechanism.as_ref());
        let names: Vec<String> = n.joints().iter().map(|j| format!("{}_{}", j.name, j.dimension.si())).collect();
        let mut text = format!("{},x_m,y_m,z_m,rx_rad,ry_rad,rz_rad\n", names.join(","));
        let poses = read_poses(bench.at("poses.csv"), &nominal).unwrap();
        for pose in poses.iter().map(|l| &l.pose) {
            let commanded = n.inverse(n.values(), pose, &at).unwrap();
            let went = t.forward(t.values(), &commanded, &at, pose).unwrap();
            // Redundant joints settle; the others stay where they were commanded.
            let joints = if t.equations() > 6 { t.inverse(t.values(), &went, &at).unwrap() } else { commanded };
            let seen = tracker.compose(&went).compose(&target).coordinates();
            let cells: Vec<String> = joints.iter().chain(&seen).map(|v| format!("{v:e}")).collect();
            text += &(cells.join(",") + "\n");
        }
        bench.write("tracker.csv", text);
        let result = bench.json("calibrate m.toml tracker.csv -o calibrated.toml");
        assert_eq!(result["frames"]["registered"], true, "{kind}");
        let turned = Pose::from_coordinates(&std::array::from_fn(|k| {
            result["frames"]["base"][if k < 3 { "position_m" } else { "rotation_rad" }][k % 3].as_f64().unwrap()
        }));
        // A delta hardly turns and a plate stays in its plane: along some axes tracker and target are one offset.
        let off = turned.motion_to(&tracker);
        assert!(off.fixed_rows::<3>(3).norm() < 5e-3 && off.fixed_rows::<3>(0).norm() < 0.2, "{kind}: {off:?}");
        let after = result["rms_after"]["position_m"].as_f64().unwrap();
        // The prior pulls at directions that the poses do not decide, by less than the stated noise.
        let noise = nominal.noise.unwrap().position;
        // What tells tracker and target of a delta apart is hardly larger than the noise.
        let most = if kind.ends_with("-delta") { 1.5 } else { 0.5 };
        assert!(after < most * noise, "{kind}: {after:.1e}");
        let again = bench.json("evaluate calibrated.toml tracker.csv");
        let again = again["rms"]["position_m"].as_f64().unwrap();
        assert!((again - after).abs() < 1e-9, "{kind}: {again:.3e} {after:.3e}");
    }
}

#[test]
fn bundled_kinds_conform_and_survive_their_own_writer() {
    for kind in KINDS {
        let machine = Machine::read(path(&format!("mechanisms/{kind}.toml"))).unwrap();
        let mechanism = machine.mechanism.as_ref();
        assert!(machine.warnings.is_empty(), "{:?}", machine.warnings);
        conformance::mechanism(mechanism, &machine.workspace.unwrap()).unwrap_or_else(|v| panic!("{kind}: {v}"));
        let frames = paracal::measurement::Frames::default();
        let document = machine.document_of(mechanism, machine.workspace.as_ref(), &frames).unwrap();
        let again = Machine::from_text(&document.to_text(), Path::new("again.toml")).unwrap();
        for (a, b) in mechanism.values().iter().zip(again.mechanism.values()) {
            assert!((a - b).abs() < 1e-14, "{kind}: {a} {b}");
        }
        assert!(mechanism.home().motion_to(&again.mechanism.home()).amax() < 1e-12, "{kind}");
    }
}

#[test]
fn a_delta_is_calibrated_by_touching_a_plane() {
    let bench = simulated("linear-delta", 40);
    bench.done("simulate m.toml --poses poses.csv --error-sd 0.1mm -o touches.csv --measure contact");
    // Heights alone say little of a pose, and that is said; where the tool touches is known.
    let printed = bench.exits(3, "calibrate m.toml touches.csv -o calibrated.toml --json").out;
    let result: serde_json::Value = serde_json::from_str(&printed).unwrap();
    assert!(result["reasons"][0].as_str().unwrap().contains("measure more and other poses"), "{result}");
    let after = result["rms_after"]["position_m"].as_f64().unwrap();
    assert!(after < 3e-5 && after < 0.5 * result["rms_before"]["position_m"].as_f64().unwrap(), "{after:.1e}");
    assert!(result["rms_after"]["rotation_rad"].is_null());
}

/// Changes one line of a bundled file and expects the refusal to say these things.
fn refused(kind: &str, from: &str, to: &str, expected: &[&str]) {
    let text = text(&format!("mechanisms/{kind}.toml"));
    assert!(text.contains(from), "{kind} has no {from}");
    Bench::empty().with("m.toml", text.replacen(from, to, 1)).refuses("inspect m.toml", expected);
}

#[test]
fn what_is_wrong_with_a_kind_is_named() {
    refused("rotary-stewart", "crank = 70.0\n", "", &["leg 1, `crank`", "is missing", "rotary-stewart"]);
    refused("rotary-stewart", "crank = 70.0", "crank = -70.0", &["leg 1, `crank`", "must be positive, found -70"]);
    refused("rotary-stewart", "crank = 70.0", "crank = 7.0", &["leg 1", "does not reach the platform at home"]);
    refused(
        "rotary-stewart",
        "stroke = [-70.0, 70.0]",
        "stroke = [70.0, -70.0]",
        &["leg 1, `stroke`", "not an interval"],
    );
    refused("rotary-stewart", "[home]", "[homes]", &["unknown field `homes`"]);
    refused("rotary-stewart", "[workspace]", "[mounting]", &["unknown field `position`", "base_position"]);
    refused("linear-delta", "carriage = 1", "carriage = 4", &["leg 1, `carriage`", "4 is not 1, 2 or 3"]);
    refused("linear-delta", "carriage = 1", "carriage = 2", &["carriage 1 has 1 rod;", "two on each of three"]);
    refused("linear-delta", "rail = [0.0, 0.0, 1.0]", "rail = [0.0, 0.0, 0.0]", &["leg 1, `rail`", "not a direction"]);
    refused("linear-delta", "rail = [0.0, 0.0, 1.0]", "rail = [0.0, 0.1, 1.0]", &["legs 1 and 2", "different rails"]);
    refused(
        "linear-delta",
        "rail = [0.0, 0.0, 1.0]",
        "rail = [nan, 0.0, 1.0]",
        &["leg 1, `rail`", "not a finite number"],
    );
    refused("tripod-3rps", "stroke", "rail = [0.0, 0.0, 1.0]\nstroke", &["leg 1, `rail`", "does not apply"]);
    refused(
        "tripod-3rps",
        "length_unit",
        "identify = [\"q\"]\nlength_unit",
        &["identify", "'q' is not a parameter", "xA"],
    );
    refused("tripod-3rps", "length_unit", "identify = []\nlength_unit", &["identify", "names no parameter"]);
    refused("tripod-3rps", "length_unit", "pivot = [0.0, 0.0, 10.0]\nlength_unit", &["pivot", "must be absent"]);
    refused("planar-cables", "segments = [1]", "segments = [9]", &["cable 1, `segments`", "9 is not a leg"]);
    refused("planar-cables", "segments = [1]", "segments = [0]", &["cable 1, `segments`", "0 is not a leg"]);
    refused("planar-cables", "segments = [1]", "segments = []", &["cable 1 has no segment"]);
    refused("planar-cables", "drum = 30.0", "drum = 0.0", &["cable 1, `drum`", "must be positive"]);
    refused("planar-cables", "rotation = [0.0, 0.0, 0.0]", "rotation = [1.0, 0.0, 0.0]", &["plane z = constant"]);
    refused("planar-cables", "drum = 30.0", "drum = 30.0\nbuild_up = 0.1", &["cable 1", "those of cables in space"]);
    refused("rotary-delta", "motor = 1\n", "", &["leg 1, `motor`", "is missing", "rotary-delta"]);
    refused("rotary-delta", "motor = 1", "motor = 4", &["leg 1, `motor`", "4 is not 1, 2 or 3"]);
    refused("rotary-delta", "motor = 1", "motor = 2", &["motor 1 has 1 rod;", "two on each of three"]);
    refused("rotary-delta", "crank = 200.0", "crank = 201.0", &["legs 1 and 2", "same motor", "different cranks"]);
    refused("six-carriages", "length = 500.0", "length = 50.0", &["leg 1", "does not reach the platform at home"]);
    refused("six-carriages", "length = 500.0\n", "length = 500.0\ncarriage = 1\n", &["`carriage`", "does not apply"]);
    refused("cables", "pulley = 30.0", "swivel = [0.0, 0.0, 1.0]", &["leg 1, `swivel`", "without `pulley`"]);
    refused("cables", "pulley = 30.0", "pulley = -30.0", &["leg 1, `pulley`", "must be positive"]);
    refused("cables", "drum = 50.0", "build_up = 0.1", &["cable 1, `build_up`", "without `drum`"]);
    refused("delta-printer", "arm = [225.0, 225.0, 225.0]", "arm = 22.5", &["tower 1", "does not reach"]);
    refused("delta-printer", "tower_radius = 105.0", "tower_radius = -105.0", &["tower_radius", "must be positive"]);
    refused("delta-printer", "endstop = [0.0, 0.0, 0.0]", "endstop = [0.0, 0.0]", &["endstop"]);
    refused(
        "delta-printer",
        "rotation = [0.0, 0.0, 0.0]",
        "rotation = [1.0, 0.0, 0.0]",
        &["does not turn", "zero rotations"],
    );
    let leg = "[[leg]]\nplatform = [0.0, 0.0, 0.0]\nbase = [0.0, 0.0, 0.0]\n\n[home]";
    refused("delta-printer", "[home]", leg, &["[delta]", "stands beside [[leg]]"]);
}

#[test]
fn an_unknown_kind_is_refused_with_the_list() {
    let known = [
        "six-hardpoint",
        "rotary-stewart",
        "rotary-delta",
        "linear-delta",
        "six-carriages",
        "tripod-3rps",
        "cables",
        "planar-cables",
        "pose",
    ];
    let quoted: Vec<String> = known.iter().map(|kind| format!("\"{kind}\"")).collect();
    let mut expected = vec!["'tripod-3rrs' is not a kind of mechanism"];
    expected.extend(quoted.iter().map(String::as_str));
    refused("tripod-3rps", "\"tripod-3rps\"", "\"tripod-3rrs\"", &expected);
}

#[test]
fn parts_of_other_kinds_are_refused() {
    let cable = "[[cable]]\nsegments = [1]\n\n[home]";
    refused("tripod-3rps", "[home]", cable, &["[[cable]]", "does not apply to type \"tripod-3rps\"", "delete it"]);
    let offset = "[offset]\nposition = [1.0, 0.0, 0.0]\n\n[home]";
    refused("planar-cables", "[home]", offset, &["[offset]", "does not apply to type \"planar-cables\""]);
}
