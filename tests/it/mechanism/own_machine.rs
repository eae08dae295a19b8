//! A mechanism that a program defines, as a machine: tables, a calibrated file, a diagnosis, commands.

// The example beside its `main`.
#[allow(dead_code)]
#[path = "../../../examples/own_mechanism.rs"]
mod example;

use std::path::Path;

use paracal::diagnosis::{Question, Verdict, diagnose};
use paracal::files::{Machine, ReadOptions};
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, calibrate};
use paracal::measurement::{Dataset, Frames};
use paracal::pose::Pose;

/// What reading this text as a file of the example's mechanism gives.
fn read(text: &str) -> Result<Machine, String> {
    let options = ReadOptions::default().with_mechanism(example::drawn().unwrap());
    Machine::from_text_with(text, Path::new("c.toml"), &options).map_err(|error| error.to_string())
}

/// The campaign of the example, and the calibrated file of its data seen in these frames.
fn calibrated(frames: &Frames) -> (Machine, Dataset, Vec<f64>, String) {
    let folder = tempfile::tempdir().unwrap();
    let (machine, mut measurement) = example::campaign(folder.path()).unwrap();
    let header = std::fs::read_to_string(folder.path().join("data.csv")).unwrap();
    assert!(header.contains("slide1_mm,slide2_mm,slide3_mm,slide4_mm,slide5_mm,slide6_mm,x_mm,"), "{header}");
    if !frames.is_identity() {
        let text = moved(&header, frames);
        let path = folder.path().join("moved.csv");
        std::fs::write(&path, text).unwrap();
        measurement = paracal::files::read_measurement(&path, &machine).unwrap();
    }
    let options = CalibrationOptions::default();
    let identifier = LevenbergMarquardt::default();
    let result =
        calibrate(machine.plain(), &measurement.data, machine.workspace.as_ref(), &identifier, &options).unwrap();
    assert!(result.verdict.trusted, "{:?}", result.verdict.reasons);
    let text = machine.calibrated_document(&result, &measurement).unwrap().to_text();
    (machine, measurement.data, result.mechanism.values().to_vec(), text)
}

/// The table with its poses as they are seen in other frames.
fn moved(table: &str, frames: &Frames) -> String {
    let mut lines = table.lines();
    let mut text: String = lines.by_ref().take(1).map(|line| format!("{line}\n")).collect();
    for line in lines.filter(|line| !line.starts_with('#')) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let q: [f64; 6] = std::array::from_fn(|k| if k < 3 { 1e-3 * cells[6 + k] } else { cells[6 + k].to_radians() });
        let seen = frames.measured(&Pose::from_coordinates(&q)).coordinates();
        let joints: Vec<String> = cells[..6].iter().map(f64::to_string).collect();
        let pose = (0..6).map(|k| if k < 3 { 1e3 * seen[k] } else { seen[k].to_degrees() }.to_string());
        text += &format!("{},{}\n", joints.join(","), pose.collect::<Vec<_>>().join(","));
    }
    text
}

#[test]
fn a_calibrated_file_holds_the_values_and_is_commanded_by_the_drawing() {
    let (machine, data, values, text) = calibrated(&Frames::default());
    assert!(text.contains("\ntype = \"own\"\n") && text.contains("\n[[parameter]]\nname = \"s6\"\n"), "{text}");
    let again = read(&text).unwrap();
    for (read, found) in again.mechanism.values().iter().zip(&values) {
        assert!((read - found).abs() < 1e-12, "{read} for {found}");
    }
    assert_eq!(again.commander().values(), machine.plain().values());
    assert_eq!(again.document().to_text(), text);
    let found = diagnose(&Question::of(&machine, &data)).unwrap();
    assert_eq!(found.verdict, Verdict::Clean);
}

#[test]
fn a_calibrated_file_of_a_tracker_far_away_predicts_what_the_tracker_sees() {
    let frames = Frames {
        base: Pose::from_coordinates(&[3.0, -2.0, 0.5, 0.2, -0.3, 1.9]),
        target: Pose::from_coordinates(&[0.05, 0.02, 0.1, 0.4, 0.1, -0.7]),
    };
    let (_, data, _, text) = calibrated(&frames);
    let again = read(&text).unwrap();
    let rms = paracal::identification::evaluate(again.mechanism.as_ref(), &[], &data).unwrap().rms();
    // The noise of a coordinate is 5 um.
    assert!(rms.position.unwrap() < 12e-6, "{rms:?}");
}

#[test]
fn what_is_wrong_with_a_file_of_an_own_mechanism_is_named() {
    let (_, _, _, text) = calibrated(&Frames::default());
    let without = Machine::from_text(&text, Path::new("c.toml")).unwrap_err().to_string();
    let first = text.find("\n[[parameter]]").unwrap();
    let second = first + 1 + text[first + 1..].find("\n[[parameter]]").unwrap();
    let lacking = format!("{}{}", &text[..first], &text[second..]);
    let cases = [
        (without, ["c.toml", "type", "a mechanism that a program defines"]),
        (read(&text.replace("\"s6\"", "\"t6\"")).unwrap_err(), ["'t6'", "is not a parameter", "s6"]),
        (read(&text.replace("\"s6\"", "\"s5\"")).unwrap_err(), ["'s5'", "is stated twice", "keep one"]),
        (read(&lacking).unwrap_err(), ["'xA1'", "is missing", "nominal mechanism"]),
    ];
    for (message, parts) in cases {
        parts.iter().for_each(|part| assert!(message.contains(part), "'{part}' is not in: {message}"));
    }
}
