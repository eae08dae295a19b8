//! Deviations of readings from a model, against joints that were really moved.

use crate::common;

use paracal::conditions::Conditions;
use paracal::identification::deviations;
use paracal::measurement::{DataRow, Dataset, Noise, PoseMeasurement, PoseReading, Sample};
use paracal::pose::{Pose, PoseConvention};
use std::sync::Arc;

/// Readings of poses, and the joints that are said to have been commanded for them.
fn data(joints: &[Vec<f64>], poses: &[Pose], measured: [bool; 6]) -> Dataset {
    let convention = PoseConvention::default();
    let reading = |p: &Pose| PoseReading { values: convention.coordinates(p), measured, sigma: [1e-6; 6] };
    let sample = |(row, joints): (usize, &Vec<f64>)| Sample {
        id: None,
        row: DataRow(row),
        joints: joints.clone(),
        ..Sample::default()
    };
    let model = PoseMeasurement::new(convention, poses.iter().map(reading).collect());
    let noise = Noise::stated(1e-6, 1e-6);
    Dataset::new(joints.iter().enumerate().map(sample).collect(), Arc::new(model), noise)
}

#[test]
fn a_leg_that_is_longer_than_commanded_is_seen_at_this_leg_alone() {
    for file in ["table5", "rotary-stewart"] {
        let machine = common::machine(file);
        let m = machine.mechanism.as_ref();
        let at = Conditions::unknown();
        let commanded = m.inverse(m.values(), &m.home(), &at).unwrap();
        for leg in 0..6 {
            let mut real = commanded.clone();
            real[leg] += 2e-6;
            let pose = m.forward(m.values(), &real, &at, &m.home()).unwrap();
            let found = deviations(m, &[], &data(std::slice::from_ref(&commanded), &[pose], [true; 6])).unwrap();
            let one = &found[0];
            assert!(one.pose.motion_to(&m.home()).amax() < 1e-9);
            assert!((one.pose.motion_to(&pose) - one.motion).amax() < 1e-9, "{file} {leg}: {}", one.motion);
            for (k, joint) in one.joints.iter().enumerate() {
                let expected = if k == leg { 2e-6 } else { 0.0 };
                assert!((joint - expected).abs() < 1e-9, "{file} leg {leg}, joint {k}: {joint}");
            }
        }
    }
}

#[test]
fn what_was_not_measured_is_taken_as_not_moved() {
    let machine = common::machine("table5");
    let m = machine.mechanism.as_ref();
    let joints = m.inverse(m.values(), &m.home(), &Conditions::unknown()).unwrap();
    let moved = m.home().moved(&[1e-5, 2e-5, -3e-5, 1e-5, 2e-5, 3e-5].into());
    let only_position = [true, true, true, false, false, false];
    let found = deviations(m, &[], &data(&[joints], &[moved], only_position)).unwrap();
    assert!((found[0].motion - nalgebra::vector![1e-5, 2e-5, -3e-5, 0.0, 0.0, 0.0]).amax() < 1e-12);
    assert_eq!(found[0].readings.len(), 3);
}
