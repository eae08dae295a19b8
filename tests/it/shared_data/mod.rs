//! Checks against reference data outside the project, found through the environment variable `PARACAL_DATA`.
//!
//! Without it they say so and pass; the bundled copies are tested elsewhere.

use crate::common;

// The two examples with measured data; their `main` is not called here.
#[allow(dead_code, unreachable_pub)]
#[path = "../../../examples/cable_robot.rs"]
mod cable_robot;
#[allow(dead_code, unreachable_pub)]
#[path = "../../../examples/delta_printer.rs"]
mod delta_printer;
mod diagnosis;
mod so_lat;
use crate::common::hidden;

use std::path::{Path, PathBuf};

use paracal::files::{Machine, read_measurement};
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, calibrate};

fn folder(name: &str) -> Option<PathBuf> {
    // Where a test runs is not its own: another one changes the current folder.
    let from = |root| Path::new(env!("CARGO_MANIFEST_DIR")).join(root).join(name);
    let found = std::env::var_os("PARACAL_DATA").map(from).filter(|p| p.is_dir());
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

/// A file of another generator, taken apart into the run and the measured poses, SI.
fn run_of(csv: &std::path::Path) -> (hidden::run::Run, Vec<[f64; 6]>) {
    let text = std::fs::read_to_string(csv).unwrap();
    let (mut rows, mut poses, mut before) = (Vec::new(), Vec::new(), [0.8; 6]);
    for line in text.lines().skip(1) {
        let v: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let commanded = std::array::from_fn(|i| 1e-3 * v[1 + i]);
        rows.push(hidden::run::Row {
            time: v[0],
            commanded,
            before,
            temp_legs: std::array::from_fn(|i| v[13 + i]),
            temp_platform: v[19],
            temp_base: v[20],
            elevation: v[21].to_radians(),
            azimuth: v[22].to_radians(),
            payload: v[23],
        });
        poses.push(std::array::from_fn(|k| if k < 3 { 1e-3 * v[7 + k] } else { v[7 + k].to_radians() }));
        before = commanded;
    }
    (hidden::run::Run::of(rows), poses)
}

/// χ² that is left of measured poses when the 42 parameters are fitted beside known effects.
fn misfit(run: &hidden::run::Run, poses: &[[f64; 6]], effects: &[hidden::effects::Planted]) -> f64 {
    use hidden::{effects::Influence, effects::measured, hexapod::Geometry, limits::NOISE};
    use paracal::nalgebra::{DMatrix, DVector};
    let influences: Vec<&dyn Influence> = effects.iter().map(|e| e as &dyn Influence).collect();
    let reached = |by: &[f64]| {
        let machine = Geometry::nominal().changed(&std::array::from_fn(|k| by[k]));
        let flat = measured(&machine, run, &influences).unwrap().concat();
        DVector::from_iterator(flat.len(), flat.iter().enumerate().map(|(k, v)| v / NOISE[usize::from(k % 6 >= 3)]))
    };
    let wanted = poses.concat();
    let wanted = DVector::from_iterator(
        wanted.len(),
        wanted.iter().enumerate().map(|(k, v)| v / NOISE[usize::from(k % 6 >= 3)]),
    );
    let at_rest = reached(&[0.0; 42]);
    let columns: Vec<DVector<f64>> = (0..42)
        .map(|j| {
            let mut by = [0.0; 42];
            by[j] = 1e-5;
            (reached(&by) - &at_rest) / 1e-2
        })
        .collect();
    // In millimetres, each held by a prior of one.
    let a = DMatrix::from_columns(&columns);
    let normal = (a.tr_mul(&a) + DMatrix::identity(42, 42)).cholesky().unwrap();
    let mut by = DVector::zeros(42);
    for _ in 0..6 {
        let residual = &wanted - reached((&by * 1e-3).as_slice());
        by += normal.solve(&(a.tr_mul(&residual) - &by));
    }
    (wanted - reached((&by * 1e-3).as_slice())).norm_squared()
}

/// Two generators that were written apart agree: with the effects of the one, the files of the other are noise.
#[test]
fn the_generator_of_blind_cases_explains_the_files_of_another() {
    let Some(folder) = folder("diagnosis-examples") else { return };
    for kind in ["effect", "pair", "null"] {
        let truths = std::fs::read_to_string(folder.join(kind).join("truth.json")).unwrap();
        let truths: serde_json::Value = serde_json::from_str(&truths).unwrap();
        for truth in truths.as_array().unwrap() {
            let (run, poses) = run_of(&folder.join(kind).join(truth["case"].as_str().unwrap()).join("data.csv"));
            let effects: Vec<hidden::effects::Planted> = (0..truth["effects"].as_array().unwrap().len())
                .map(|k| hidden::effects::Planted {
                    name: hidden::effects::named(truth["effects"][k].as_str().unwrap()).unwrap().name,
                    leg: truth["leg"][k].as_u64().map(|leg| leg as usize - 1),
                    row: truth["row"][k].as_u64().map(|row| row as usize),
                    theta: truth["parameters_si"][k].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect(),
                })
                .collect();
            let (without, with) = (misfit(&run, &poses, &[]), misfit(&run, &poses, &effects));
            println!("{kind} {}: {without:.0} without, {with:.0} with", truth["effects"]);
            // 720 numbers, 42 parameters of which the prior holds some: 685 ± 37.
            assert!((with - 685.0).abs() < 4.0 * 37.0, "{kind} {truth}: {with}");
            assert!(effects.is_empty() || without > with + 200.0);
        }
    }
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
