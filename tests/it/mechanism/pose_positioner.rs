//! Positioners in pose space: laws, files, and calibration by hand.

use crate::common;

use paracal::effect::{Environment, Sensor};
use paracal::files::{Machine, read_measurement};
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, calibrate};
use paracal::measurement::Frames;
use paracal::mechanism::{Body, Mechanism, ParameterRole, PosePositioner, Workspace};
use paracal::nalgebra::Vector3;
use paracal::pose::{PoseConvention, RotationOrder};
use paracal::units::Dimension;

const FILE: &str = "name = \"stage\"\ntype = \"pose\"\nlength_unit = \"um\"\nangle_unit = \"arcsec\"\n";

fn machine(further: &str) -> Machine {
    Machine::from_text(&format!("{FILE}{further}"), "stage.toml".as_ref()).unwrap()
}

#[track_caller]
fn refused(text: &str, parts: &[&str]) {
    let message = Machine::from_text(text, "stage.toml".as_ref()).unwrap_err().to_string();
    for part in parts {
        assert!(message.contains(part), "'{part}' is not in: {message}");
    }
}

#[test]
fn it_is_a_mechanism() {
    let pivot = Vector3::new(0.1, -0.2, 0.7);
    for convention in [PoseConvention::default(), PoseConvention { order: RotationOrder::Xyz, pivot }] {
        let centre = [0.2, -0.1, 0.5, 0.1, -0.3, 0.4];
        let offsets = [1e-3, -2e-3, 3e-4, 1e-3, 2e-3, -5e-4];
        let made = PosePositioner::new("stage", convention, convention.pose(&centre), offsets, None).unwrap();
        let workspace = Workspace { convention, centre, half: [0.1, 0.1, 0.1, 0.3, 0.3, 0.3] };
        paracal::conformance::mechanism(&made, &workspace).unwrap();
        let names: Vec<&str> = made.joints().iter().map(|j| j.name.as_str()).collect();
        assert_eq!(names, ["cmd_x", "cmd_y", "cmd_z", "cmd_rx", "cmd_ry", "cmd_rz"]);
        let spec = &made.parameters()[4];
        assert_eq!((spec.name.as_str(), spec.dimension), ("dry", Dimension::Angle));
        assert_eq!(spec.role, ParameterRole::PoseOffset { coordinate: 4 });
    }
}

#[test]
fn its_file_is_read_and_written() {
    let further = "reference_temperature_degC = 10\n[offset]\nposition = [1.0, 2.0, 3.0]\nrotation = [4.0, 5.0, 6.0]\n\
        [tolerance]\nanchor = 100.0\nangle = 50.0\n\
        [[sensor]]\ncovariate = \"temp_base1\"\nbase = [1e6, 0, 0]\n\
        [[sensor]]\ncovariate = \"temp_top\"\nplatform = [0, 2e6, 0]\n";
    let read = machine(further);
    let values = read.mechanism.values();
    assert!((values[1] - 2e-6).abs() < 1e-18 && (values[5] - (6.0_f64 / 3600.0).to_radians()).abs() < 1e-18);
    assert!((read.mechanism.parameters()[2].tolerance.unwrap() - 1e-4).abs() < 1e-18);
    let sensor = |covariate: &str, body, place| Sensor { covariate: covariate.into(), body, place };
    let expected = Environment {
        reference_temperature: Some(10.0),
        sensors: vec![
            sensor("temp_base1", Body::Base, Vector3::new(1.0, 0.0, 0.0)),
            sensor("temp_top", Body::Platform, Vector3::new(0.0, 2.0, 0.0)),
        ],
        ..Environment::default()
    };
    let stated = |machine: &Machine| Environment {
        home: None,
        home_joints: None,
        home_legs: None,
        ..(**machine.environment()).clone()
    };
    assert_eq!(stated(&read), expected);
    let moved: Vec<f64> = values.iter().map(|v| v + 1e-6).collect();
    let moved = read.mechanism.with_values(&moved, read.mechanism.home()).unwrap();
    let text = read.document_of(moved.as_ref(), None, &Frames::default()).unwrap().to_text();
    let again = Machine::from_text(&text, "again.toml".as_ref()).unwrap();
    for (a, b) in again.mechanism.values().iter().zip(moved.values()) {
        assert!((a - b).abs() < 1e-15);
    }
    assert_eq!(stated(&again), expected);
    assert_eq!(again.document().to_text(), text);
}

#[test]
fn offsets_are_the_mean_of_what_is_off() {
    // Two commands in three rows, no rz measured, one column of commands absent: offsets are means of the differences.
    let machine = machine("");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.csv");
    let text = "cmd_x_um,cmd_rx_arcsec,x_um,y_um,z_um,rx_arcsec,ry_arcsec\n\
        0,0,10,7,-3,5,1\n100,20,112,8,-2,26,2\n0,0,11,9,-4,4,3\n50,0,57,8,-3,5,2\n";
    std::fs::write(&path, text).unwrap();
    let data = read_measurement(&path, &machine).unwrap().data;
    let options = CalibrationOptions { convention: machine.convention, ..CalibrationOptions::default() };
    let identifier = LevenbergMarquardt::default();
    let result = calibrate(machine.mechanism.as_ref(), &data, None, &identifier, &options).unwrap();
    let arcsec = (1.0_f64 / 3600.0).to_radians();
    let expected = [10.0e-6, 8.0e-6, -3.0e-6, 5.0 * arcsec, 2.0 * arcsec];
    for (estimate, expected) in result.parameters.iter().zip(expected) {
        assert!((estimate.value - expected).abs() < 1e-12, "{}: {}", estimate.spec.name, estimate.value);
        assert!(estimate.sigma.is_some());
    }
    // Nothing is known of rz: it stays where it was, and the result says so.
    assert!(result.parameters[5].value.abs() < 1e-15 && result.parameters[5].sigma.is_none());
    assert!(!result.registration.applied && !result.verdict.trusted);
    assert!(result.weak[0].text.contains("drz"), "{}", result.weak[0].text);
    // With tolerances it is known as well as they say.
    let machine = machine_with_tolerance();
    let result = calibrate(machine.mechanism.as_ref(), &data, None, &identifier, &options).unwrap();
    let sigma = result.parameters[5].sigma.unwrap();
    assert!((sigma / (50.0 * arcsec) - 1.0).abs() < 1e-6 && result.verdict.trusted, "{sigma:e}");
}

fn machine_with_tolerance() -> Machine {
    machine("[tolerance]\nanchor = 100.0\nangle = 50.0\n")
}

#[test]
fn far_offsets_are_offsets_and_no_frames() {
    let machine = machine("");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.csv");
    let rows: Vec<String> =
        (0..4).map(|k| format!("{0},0,0,0,0,0,{1},250000,0,0,20000,0", 1000 * k, 1000 * k)).collect();
    let six = |prefix: &str| {
        format!("{prefix}x_um,{prefix}y_um,{prefix}z_um,{prefix}rx_arcsec,{prefix}ry_arcsec,{prefix}rz_arcsec")
    };
    std::fs::write(&path, format!("{},{}\n{}\n", six("cmd_"), six(""), rows.join("\n"))).unwrap();
    let data = read_measurement(&path, &machine).unwrap().data;
    let options = CalibrationOptions { convention: machine.convention, ..CalibrationOptions::default() };
    let result = calibrate(machine.mechanism.as_ref(), &data, None, &LevenbergMarquardt::default(), &options).unwrap();
    assert!((result.parameters[1].value - 0.25).abs() < 1e-9, "{}", result.parameters[1].value);
    assert!(!result.registration.applied && result.after.position.unwrap() < 1e-9);
}

#[test]
fn what_means_nothing_is_refused() {
    let leg = "[[leg]]\nplatform = [0, 0, 0]\nbase = [0, 0, 0]\n";
    refused(&format!("{FILE}{leg}"), &["stage.toml: [[leg]]", "does not apply to type \"pose\"", "delete it"]);
    refused(&format!("{FILE}[noise]\nposition = 1\nrotation = 1\njoint = 1\n"), &["[noise] joint", "does not apply"]);
    refused(&format!("{FILE}[tolerance]\nanchor = 1\n"), &["[tolerance] angle", "is missing"]);
    refused(&format!("{FILE}[offset]\nposition = [nan, 0, 0]\n"), &["[offset]", "not a finite number"]);
    refused(
        &format!("{FILE}[home]\nposition = [0, 0, 0]\nrotation = [0, 324000, 0]\n"),
        &["stage.toml", "singular at home"],
    );
    let sensor = |text: &str| format!("{FILE}[[sensor]]\n{text}\n");
    refused(&sensor("covariate = \"temp_base1\""), &["sensor 1, `base`", "is missing"]);
    refused(&sensor("covariate = \"temp_a\"\nbase = [0, 0, 0]\nplatform = [0, 0, 0]"), &["sensor 1", "keep one"]);
    refused(&sensor("covariate = \"temp_a_degC\"\nbase = [0, 0, 0]"), &["'temp_a_degC'", "without its unit"]);
    refused(&sensor("covariate = \"load\"\nbase = [0, 0, 0]"), &["'load'", "not the name of a temperature"]);
    let twice = "covariate = \"temp_a\"\nbase = [0, 0, 0]\n[[sensor]]\ncovariate = \"temp_a\"\nbase = [1, 0, 0]";
    refused(&sensor(twice), &["sensor 2", "already that of sensor 1"]);
    let offset = format!("{}\n[offset]\nposition = [1, 0, 0]\n", common::text("mechanisms/table5.toml"));
    refused(&offset, &["[offset]", "does not apply to type \"six-hardpoint\""]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.csv");
    std::fs::write(&path, "leg1_mm,x_um,y_um,z_um\n800,0,0,0\n").unwrap();
    let message = read_measurement(&path, &machine("")).unwrap_err().to_string();
    assert!(message.contains("'leg1_mm'") && message.contains("no legs; its joints are cmd_x"), "{message}");
}
