//! Joints and parameters that are angles are shown, drawn and read as angles.

use crate::common;

use crate::common::rotary::{Rotary, workspace};
use paracal::conditions::Conditions;
use paracal::files::read_parameter_errors;
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, calibrate};
use paracal::measurement::Noise;
use paracal::mechanism::{Body, Mechanism, Survey, characteristic_length, condition};
use paracal::pose::Pose;
use paracal::report::{json, text};
use paracal::selection::preview;
use paracal::simulation::{as_dataset, draw_parameters, simulate};
use paracal::units::Dimension;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

/// A calibration of a mechanism whose parameters have these errors, SI.
fn calibrated(m: &Rotary, errors: &[f64]) -> paracal::identification::Calibration {
    let space = workspace();
    let noise = Noise::stated(1e-6, 1e-6);
    let mut rng = ChaCha8Rng::seed_from_u64(71);
    let values: Vec<f64> = m.values().iter().zip(errors).map(|(v, e)| v + e).collect();
    let truth = m.with_values(&values, m.home()).unwrap();
    let poses: Vec<Pose> = (0..40).map(|_| space.random(&mut rng)).collect();
    let samples = simulate(m, truth.as_ref(), &poses, &space.convention, &noise, &mut rng).unwrap();
    let data = as_dataset(&samples, &space.convention, &noise);
    calibrate(m, &data, Some(&space), &LevenbergMarquardt::default(), &CalibrationOptions::default()).unwrap()
}

#[test]
fn the_table_of_the_legs_has_the_unit_of_each_column() {
    let m = Rotary::new();
    let mut errors = vec![0.0; 21];
    errors[2] = 3e-3;
    let result = calibrated(&m, &errors);
    let shown = text::calibration(&result);
    let mut lines = shown.lines().skip_while(|l| !l.starts_with("Deviation"));
    assert_eq!(lines.next(), Some("Deviation from the mechanism file; 1 sigma below it (~)"));
    let header = lines.next().unwrap();
    let columns = ["xA (mm)", "yA (mm)", "o (deg)", "r (mm)", "s (mm)", "xB (mm)", "yB (mm)"];
    assert_eq!(header.split("  ").map(str::trim).filter(|c| !c.is_empty()).skip(1).collect::<Vec<_>>(), columns);
    let offset = result.parameters[2].value - result.parameters[2].start;
    let cells: Vec<&str> = lines.next().unwrap().split_whitespace().collect();
    assert_eq!(cells[3], format!("{:+.5}", offset.to_degrees()));
    let table = shown.lines().skip_while(|l| !l.starts_with("leg ")).take(7);
    assert!(table.into_iter().all(|l| l.chars().count() <= 80), "{shown}");
    // The offsets are no lengths.
    let object = json::calibration(&result, &[]);
    assert!(object["frames"]["leg_offsets_m"].is_null());
    assert!((object["frames"]["joint_offsets"][0].as_f64().unwrap() - offset).abs() < 1e-15);
    assert_eq!(object["parameters"][2]["unit"], "rad");
}

#[test]
fn a_worst_deviation_is_that_with_the_most_tolerances() {
    let m = Rotary::new();
    let mut errors = vec![0.0; 21];
    (errors[3], errors[4]) = (12e-3, -4.5e-3);
    let result = calibrated(&m, &errors);
    let worst = result.plausibility.implausible.iter().find(|p| p.name == "r1").unwrap();
    assert_eq!(worst.dimension, Dimension::Length);
    assert!(result.verdict.warnings.iter().any(|w| w.contains("r1 (+") && w.contains(" mm)")), "{:?}", result.verdict);
}

#[test]
fn inspection_shows_angles_in_degrees_and_does_not_mix_sigmas() {
    let m = Rotary::new();
    let space = workspace();
    let c = m.values();
    let joints = m.inverse(c, &m.home(), &Conditions::unknown()).unwrap();
    let ahead = preview(&m, &space, &Noise::stated(1e-6, 1e-6), 20, 0).unwrap();
    let of = |dimension| {
        let members = m.parameters().iter().enumerate().filter(|(_, s)| s.dimension == dimension);
        common::rms(members.map(|(k, _)| ahead.forecast.covariance[(k, k)].sqrt() * ahead.scale[k]))
    };
    let expected = format!(
        "parameters to {} and {} (RMS sigma",
        paracal::units::show_length(of(Dimension::Length)),
        paracal::units::show_angle(of(Dimension::Angle))
    );
    let seen = text::Inspection {
        mechanism: &m,
        convention: &space.convention,
        platform: Body::Platform.points(&m, c),
        base: Body::Base.points(&m, c),
        lengths: Vec::new(),
        home_joints: joints.clone(),
        radius: characteristic_length(&m),
        home_condition: condition(&m, c, &joints, &m.home(), &Conditions::unknown()),
        survey: Some(Survey::of(&m, &space, &[])),
        preview: Some(ahead),
        weak: Vec::new(),
        warnings: Vec::new(),
    };
    let shown = text::inspection(&seen);
    assert!(shown.contains(&format!(" {:.3} deg", joints[0].to_degrees())), "{shown}");
    assert!(shown.contains(" -400.000 -692.820 0.000  "), "{shown}");
    assert!(shown.contains(&expected), "{expected}\n{shown}");
    let object = json::inspection(&seen);
    assert_eq!(object["joint_units"], serde_json::json!(["rad", "rad", "rad"]));
    assert!(object["legs"][0]["length"].is_null());
}

#[test]
fn drawn_errors_of_angles_move_the_platform_as_far_as_those_of_lengths() {
    let m = Rotary::new();
    let mut rng = ChaCha8Rng::seed_from_u64(72);
    let (mut lengths, mut angles) = (Vec::new(), Vec::new());
    for _ in 0..400 {
        for ((drawn, value), spec) in
            draw_parameters(&m, Some(1e-3), &mut rng).iter().zip(m.values()).zip(m.parameters())
        {
            let errors = if spec.dimension == Dimension::Angle { &mut angles } else { &mut lengths };
            errors.push(drawn - value);
        }
    }
    // The platform points lie 0.2 m from their centre.
    let (length, angle) = (common::rms(lengths), common::rms(angles));
    assert!((length / 1e-3 - 1.0).abs() < 0.05 && (angle / 5e-3 - 1.0).abs() < 0.1, "{length} {angle}");
}

#[test]
fn parameter_errors_are_columns_in_the_unit_of_the_parameter() {
    let m = Rotary::new();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("e.csv");
    let read = |text: &str| {
        std::fs::write(&file, text).unwrap();
        read_parameter_errors(&file, &m).map_err(Box::new)
    };
    let errors = read("leg,xA_mm,s_um,o_deg\n3,1,20,0.5\n1,0,0,-1\n").unwrap();
    let set: Vec<(usize, f64)> = errors.iter().copied().enumerate().filter(|(_, e)| *e != 0.0).collect();
    let expected = [(2, -1_f64.to_radians()), (14, 1e-3), (16, 0.5_f64.to_radians()), (18, 2e-5)];
    assert_eq!(set.len(), expected.len());
    for ((k, e), (place, value)) in set.iter().zip(expected) {
        assert!(*k == place && (e - value).abs() < 1e-15, "{set:?}");
    }
    let message = |text: &str| read(text).unwrap_err().to_string();
    assert!(message("leg,o_mm\n1,1\n").contains("use rad | mrad | deg | arcsec"), "{}", message("leg,o_mm\n1,1\n"));
    assert!(message("leg,h_mm\n1,1\n").contains("use xA yA o r s xB yB with a unit"));
    assert!(message("leg,o_deg\n4,1\n").contains("from 1 to 3"));
}
