//! Checks against reference data outside the project, found through the environment variable `PARACAL_DATA`.
//!
//! Without it they say so and pass; the bundled copies are tested elsewhere.
#![allow(clippy::unwrap_used)]

mod common;

// The two examples with measured data; their `main` is not called here.
#[allow(dead_code, unreachable_pub)]
#[path = "../examples/cable_robot.rs"]
mod cable_robot;
#[allow(dead_code, unreachable_pub)]
#[path = "../examples/delta_printer.rs"]
mod delta_printer;

use std::path::PathBuf;

use paracal::files::{Machine, read_measurement};
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, calibrate};

fn folder(name: &str) -> Option<PathBuf> {
    let found = std::env::var_os("PARACAL_DATA").map(|root| PathBuf::from(root).join(name)).filter(|p| p.is_dir());
    if found.is_none() {
        eprintln!("skipped: PARACAL_DATA does not lead to {name}");
    }
    found
}

#[test]
fn the_hardpoint_reference_is_met_and_the_bundled_copies_are_the_same() {
    let Some(folder) = folder("hardpoint-reference") else { return };
    let machine = Machine::read(folder.join("mechanism.toml")).unwrap();
    let read = |name: &str| read_measurement(folder.join(name), &machine).unwrap().data;
    let identifier = LevenbergMarquardt::default();
    let options = CalibrationOptions::default();
    let mechanism = machine.mechanism.as_ref();
    let result = calibrate(mechanism, &read("exact.csv"), machine.workspace.as_ref(), &identifier, &options).unwrap();
    let (position, rotation) = common::errors_of(result.mechanism.as_ref(), &read("targets_exact.csv"));
    assert!(position <= 1e-12 && rotation <= 1e-10_f64.to_radians(), "{position:.2e} m, {rotation:.2e} rad");
    for (theirs, ours) in [
        ("exact.csv", "hardpoint-exact.csv"),
        ("noisy.csv", "hardpoint-noisy.csv"),
        ("targets_exact.csv", "hardpoint-targets.csv"),
        ("truth_errors_mm.csv", "hardpoint-errors.csv"),
    ] {
        let theirs = std::fs::read_to_string(folder.join(theirs)).unwrap();
        assert_eq!(theirs, common::text(&format!("examples/data/{ours}")));
    }
}

#[test]
fn the_anchors_of_a_measured_cable_robot_leave_two_millimetres() {
    let Some(folder) = folder("kamal-cdpr") else { return };
    let rms = cable_robot::run(folder.parent().unwrap()).unwrap();
    for (found, expected) in rms.iter().zip([2.1, 2.7, 2.3]) {
        assert!((found - expected).abs() <= 0.1, "{rms:.2?} mm");
    }
}

#[test]
fn six_parameters_of_a_measured_delta_printer_leave_39_um() {
    let Some(folder) = folder("delta-printer-41") else { return };
    let rms = delta_printer::run(folder.parent().unwrap()).unwrap();
    assert!((rms - 39e-6).abs() <= 1e-6, "{:.1} um", 1e6 * rms);
}

#[test]
fn a_telescope_in_pose_space_is_read_and_calibrated() {
    let Some(folder) = folder("mmt-hexapod") else { return };
    let text = "name = \"secondary\"\ntype = \"pose\"\nlength_unit = \"um\"\nangle_unit = \"arcsec\"\n";
    let machine = Machine::from_text(text, "secondary.toml".as_ref()).unwrap();
    for (name, rows) in [("elcoll_20170110_0.csv", 37), ("elcoll_20170110_1.csv", 12)] {
        let read = read_measurement(folder.join(name), &machine).unwrap();
        assert_eq!(read.data.len(), rows);
        let state = &read.data.sample(rows - 1).conditions;
        assert!(state.gravity.is_some() && state.get("temp_ambient").is_some());
        assert_eq!(state.run.as_ref().unwrap().part, 1.0);
        let options = CalibrationOptions { convention: machine.convention, ..CalibrationOptions::default() };
        let result =
            calibrate(machine.mechanism.as_ref(), &read.data, None, &LevenbergMarquardt::default(), &options).unwrap();
        // Each offset is the mean of its column, to what the curvature of angles is worth; rz was not measured.
        let (model, _) = read.data.reading(0);
        let mean_x = (0..rows).map(|k| model.point(k).unwrap().position.x).sum::<f64>() / rows as f64;
        assert!((result.parameters[0].value - mean_x).abs() < 1e-9, "{}", result.parameters[0].value);
        assert_eq!(result.parameters[5].sigma, None);
    }
}
