//! Effects on the command line: simulated, identified, compensated, listed; and what is wrong with a call.

use crate::common;
use crate::common::bench::{Bench, TABLE_5, says};

use paracal::effect::effects_of;
use paracal::files::{Machine, read_measurement};
use paracal::identification::evaluate;
use serde_json::Value;

const LIST: &str = "x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg,note,temp_legs_degC,elevation_deg,payload_kg,time_utc\n";

fn list(rows: usize) -> String {
    let mut text = LIST.to_owned();
    for k in 0..rows {
        let u = |p: usize| (((k + 1) * p) % 17) as f64 / 8.0 - 1.0;
        text += &format!(
            "{:.3},{:.3},{:.3},{:.4},{:.4},{:.4},row {k},{:.1},{},{},12:{:02}:00\n",
            40.0 * u(3),
            40.0 * u(5),
            475.7 + 40.0 * u(7),
            3.0 * u(11),
            3.0 * u(13),
            3.0 * u(2),
            18.0 + 3.0 * u(6),
            20 + (7 * k) % 60,
            (k % 3) * 50,
            k
        );
    }
    text
}

/// A folder with a mechanism file and a list of poses in changing conditions.
fn with_poses(further: &str) -> Bench {
    Bench::empty().with("m.toml", common::effects::hexapod("", further)).with("p.csv", list(24))
}

fn simulated(bench: &Bench, effects: &[&str]) -> (Value, String) {
    let mut words: Vec<&str> = "simulate m.toml --poses p.csv -o d.csv --truth t.toml --error-sd 0.3mm \
                                --noise-position 0um --noise-rotation 0deg"
        .split(' ')
        .filter(|word| !word.is_empty())
        .collect();
    effects.iter().for_each(|e| words.extend(["--effect", e]));
    bench.json_and_warnings(&words[..])
}

/// Without the warning of the remarks in the list, which would stand before the error.
#[track_caller]
fn refuses(bench: &Bench, words: &[&str], parts: &[&str]) {
    bench.refuses(&[words, &["--quiet"]].concat()[..], parts);
}

/// Largest errors of a model on data, m and rad.
fn errors(bench: &Bench, mechanism: &str, data: &str) -> (f64, f64) {
    let machine = Machine::read(bench.at(mechanism)).unwrap();
    let data = read_measurement(bench.at(data), &machine).unwrap().data;
    let largest = evaluate(machine.mechanism.as_ref(), &[], &data).unwrap().max();
    (largest.position.unwrap(), largest.rotation.unwrap())
}

const SCALES: &str = "scale.per_leg=1e-3,-5e-4,8e-4,0,-1.2e-3,6e-4";
const EVERYTHING: [&str; 7] = [
    SCALES,
    "thermal.legs.uniform=1.17e-5",
    "compliance.payload=5e-8",
    "backlash=2e-5,1e-5,0,-1e-5,3e-5,1e-5",
    "joint.pivot_shift=0.02",
    "hysteresis.play[of=80um]=1,0.5,0,1,1,1",
    "sag.platform=1e-5,-2e-5",
];

#[test]
fn a_simulated_truth_explains_its_own_data() {
    let bench = with_poses("");
    let effects =
        [&EVERYTHING[..], &["drift.leg[leg=3]=4e-5", "step.frame[row=12]=1e-5,0,0,0,0,2e-5", "sag.frame=5e-5,2e-5"]]
            .concat();
    let (shown, warnings) = simulated(&bench, &effects);
    says(&warnings, &["are taken as the means of p.csv: temp_legs", "note"]);
    assert_eq!(shown["effects"].as_array().unwrap().len(), 10);
    // The conditions are in the data as they stood in the list; remarks are not.
    let (data, poses) = (bench.text("d.csv"), bench.text("p.csv"));
    let header: Vec<&str> = data.lines().next().unwrap().split(',').collect();
    assert_eq!(header[12..], ["temp_legs_degC", "elevation_deg", "payload_kg", "time_utc"]);
    for (there, here) in data.lines().skip(1).zip(poses.lines().skip(1)) {
        let last = |line: &str| line.rsplitn(5, ',').take(4).map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(last(there), last(here));
    }
    let (position, rotation) = errors(&bench, "t.toml", "d.csv");
    assert!(position < 1e-12 && rotation < 1e-12, "{position:e} m, {rotation:e} rad");
    // Each effect matters: without it the truth does not fit.
    let truth = bench.text("t.toml");
    let whole = Machine::read(bench.at("t.toml")).unwrap();
    for k in 0..whole.document().effects.len() {
        let mut document = whole.document().clone();
        let removed = document.effects.remove(k);
        bench.write("part.toml", document.to_text());
        let (position, _) = errors(&bench, "part.toml", "d.csv");
        assert!(position > 1e-7, "{} does nothing: {position:e} m", removed.name);
    }
    assert!(truth.contains("reference = { temp_legs = "), "{truth}");
}

#[test]
fn parameter_errors_are_drawn_for_parameters_only() {
    let bench = with_poses("");
    let (with, _) = simulated(&bench, &EVERYTHING);
    let (without, _) = simulated(&bench, &[]);
    assert_eq!(with["true_values"], without["true_values"]);
    let truth = |bench: &Bench| Machine::read(bench.at("t.toml")).unwrap();
    assert!(truth(&bench).effects().is_empty());
    simulated(&bench, &[SCALES]);
    assert_eq!(effects_of(truth(&bench).mechanism.as_ref())[0].values, [1e-3, -5e-4, 8e-4, 0.0, -1.2e-3, 6e-4]);
}

#[test]
fn compensated_commands_lead_the_truth_to_the_poses() {
    let bench = with_poses("");
    simulated(&bench, &EVERYTHING);
    let (shown, warnings) = bench.json_and_warnings("compensate t.toml p.csv -o l.csv");
    assert!(!warnings.contains("left out") && !warnings.contains("not compensated"), "{warnings}");
    assert_eq!(shown["effects"].as_array().unwrap().len(), EVERYTHING.len());
    // The table holds the commands and the wanted poses: as data, the truth has no error on them.
    let (position, rotation) = errors(&bench, "t.toml", "l.csv");
    assert!(position < 1e-9 && rotation < 1e-9, "{position:e} m, {rotation:e} rad");
}

#[test]
fn what_the_instrument_sees_is_compensated_in_its_frame() {
    let bench = with_poses("");
    simulated(
        &bench,
        &["sag.frame=5e-5,2e-5", "drift.frame=1e-5,0,0,0,0,0", "drift.leg[leg=2]=1e-5", "step.leg[leg=1,row=4]=1e-5"],
    );
    let (_, warnings) = bench.json_and_warnings("compensate t.toml p.csv -o l.csv");
    says(&warnings, &["sag.frame is not compensated", "--in-tracker-frame"]);
    for name in
        ["drift.frame is not", "drift.leg[leg=2] is not compensated", "step.leg[leg=1,row=4] is not compensated"]
    {
        says(&warnings, &[name]);
    }
    // Without the drifts and the step the tracker reads the wanted poses.
    let mut document = Machine::read(bench.at("t.toml")).unwrap().document().clone();
    document.effects.retain(|e| e.name == "sag.frame");
    bench.write("sag.toml", document.to_text());
    let (_, warnings) = bench.json_and_warnings("compensate sag.toml p.csv -o s.csv --in-tracker-frame");
    assert!(!warnings.contains("not compensated"), "{warnings}");
    let (position, rotation) = errors(&bench, "sag.toml", "s.csv");
    assert!(position < 1e-12 && rotation < 1e-12, "{position:e} m, {rotation:e} rad");
    assert!(errors(&bench, "sag.toml", "l.csv").0 > 1e-5);
}

#[test]
fn conditions_that_are_missing_or_unusual_are_named() {
    let entry = "\n[[effect]]\nname = \"thermal.legs.uniform\"\nparameters = { expansion = 1e-5 }\n\
        range = { temp_legs = [17.0, 19.5] }\nreference = { temp_legs = 18.0 }\n";
    let bench = with_poses(entry);
    let (shown, warnings) = bench.json_and_warnings("compensate m.toml p.csv -o l.csv");
    says(
        &warnings,
        &["thermal.legs.uniform: temp_legs is", "degC in data row", "outside the range 17.0000 to 19.5000 degC"],
    );
    assert!(shown["warnings"].as_array().unwrap().len() >= 2, "{shown}");
    let poses = bench.text("p.csv");
    let cold = poses.lines().map(|line| {
        let mut cells: Vec<&str> = line.split(',').collect();
        if cells[6] == "row 3" || cells[6] == "row 5" {
            cells[7] = "";
        }
        cells.join(",") + "\n"
    });
    let bench = with_poses(entry).with("q.csv", cold.collect::<String>());
    let (_, warnings) = bench.json_and_warnings("compensate m.toml q.csv -o l.csv");
    says(&warnings, &["thermal.legs.uniform is left out in data row 3, 5: it needs temp_legs", "fill in the cells"]);
}

#[test]
fn an_extended_model_is_calibrated_and_listed() {
    let zeros: Vec<String> = (1..=6).map(|k| format!("scale{k} = 0.0")).collect();
    let entry = format!(
        "\n[[effect]]\nname = \"scale.per_leg\"\nparameters = {{ {} }}\n\n[[effect]]\nname = \"sag.frame\"\n\
         parameters = {{ shift = 0.0, tilt = 0.0 }}\n",
        zeros.join(", ")
    );
    let bench = with_poses("").with("start.toml", common::effects::hexapod("", &entry));
    simulated(&bench, &[SCALES, "sag.frame=5e-5,2e-5"]);
    let words = ["calibrate", "start.toml", "d.csv", "-o", "c.toml", "--prior", "none"];
    let (shown, _) = bench.json_and_warnings(&words);
    let found = |name: &str| {
        let list = if name.starts_with("sag") { "measurement_parameters" } else { "parameters" };
        let all = shown[list].as_array().unwrap();
        all.iter().find(|p| p["name"] == name).unwrap_or_else(|| panic!("{name}"))["value"].as_f64().unwrap()
    };
    assert!((found("scale.per_leg.scale5") + 1.2e-3).abs() < 1e-6);
    assert!((found("sag.frame.shift") - 5e-5).abs() < 1e-6);
    let (position, rotation) = errors(&bench, "c.toml", "d.csv");
    assert!(position < 1e-8 && rotation < 1e-8, "{position:e} m, {rotation:e} rad");
    let (shown, _) = bench.json_and_warnings("inspect c.toml");
    assert_eq!(shown["effects"][0]["effect"], "scale.per_leg");
    assert_eq!(shown["effects"][1]["effect"], "sag.frame");
    assert_eq!(shown["effects"][1]["parameters"][1]["unit"], "rad");
    assert!(shown["effects"][1]["range"]["elevation"][1].as_f64().unwrap() > 1.0);
    let text = bench.done("inspect c.toml").out;
    says(
        &text,
        &["Effects:", "scale.per_leg: scale1 1000 ppm", "sag.frame (seen by the instrument only): shift 50.0 um"],
    );
    assert!(bench.text("c.toml").contains("sigma = { shift = "));
}

#[test]
fn wrong_effects_of_a_call_are_named() {
    let bench = with_poses("\n[[effect]]\nname = \"scale.common\"\nparameters = { scale = 1e-3 }\n");
    let simulate = |effect: &str, parts: &[&str]| {
        let words = ["simulate", "m.toml", "--poses", "p.csv", "-o", "d.csv", "--effect", effect];
        refuses(&bench, &words, &[&["--effect", effect][..], parts].concat());
    };
    simulate("sag=1", &["'sag' is not an effect", "sag.frame"]);
    simulate("sag.frame=1e-5", &["has 1 of the 2 values", "shift (m), tilt (rad)"]);
    simulate("scale.per_leg=1e-3,2e-3", &["has 2 of the 6 values", "scale1 (1)"]);
    simulate("drift.leg=1e-5", &["`leg`", "is missing"]);
    simulate("drift.leg[leg=9]=1e-5", &["there is no leg 9"]);
    simulate("drift.leg[leg=x]=1e-5", &["'leg=x' is not a whole number", "drift.leg[leg=3]=2e-5"]);
    simulate("drift.leg[arm=3]=1e-5", &["'arm' is none of leg, row, of"]);
    simulate("drift.leg[leg=3=1e-5", &["has no ']'"]);
    simulate("drift.leg[leg=3]", &["has no '='"]);
    simulate("drift.leg", &["has no '='"]);
    simulate("sag.frame=1e-5,big", &["'big' is not a number"]);
    simulate("sag.frame=1e-5,nan", &["'tilt' is NaN", "not a finite number"]);
    simulate("hysteresis.play=1,1,1,1,1,1", &["`of`", "is missing"]);
    simulate("sag.linear=1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,18", &["needs a mechanism of type \"pose\""]);
    simulate("scale.common=1e-3", &["scale.common is stated twice"]);
    let words = ["simulate", "m.toml", "--poses", "p.csv", "-o", "d.csv", "--effect", "thermal.platform=1e-5"];
    refuses(&bench, &words, &["p.csv: data row 0", "thermal.platform needs temp_platform", "add the column"]);
    let bare = with_poses("").with("m.toml", TABLE_5);
    let words = ["simulate", "m.toml", "--poses", "p.csv", "-o", "d.csv", "--effect", "compliance.payload=1e-8"];
    refuses(&bare, &words, &["needs [platform] payload_centre", "state it"]);
}
