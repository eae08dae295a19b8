//! Data in the tracker's own frame, metres and right angles away.

use crate::common;

use std::sync::Arc;

use crate::common::{data, errors_of, machine, paper_noise, true_mechanism, workspace};
use paracal::identification::{
    Calibration, CalibrationOptions, Holdout, LevenbergMarquardt, calibrate, pose_covariance, register,
};
use paracal::measurement::{Dataset, Frames, PoseMeasurement, PoseReading, Sample};
use paracal::mechanism::Mechanism;
use paracal::nalgebra::{Rotation3, Unit, Vector3};
use paracal::pose::{Pose, PoseConvention};
use paracal::simulation::{as_dataset, draw_parameters, simulate};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

fn turned(axis: Vector3<f64>, degrees: f64, position: Vector3<f64>) -> Pose {
    Pose { position, rotation: Rotation3::from_axis_angle(&Unit::new_normalize(axis), degrees.to_radians()) }
}

/// The frames of the requirement: 120° about a skew axis and 5 m; a target 300 mm off and turned by 40°.
fn far_frames(axis: Vector3<f64>, degrees: f64) -> Frames {
    Frames {
        base: turned(axis, degrees, Vector3::new(3.0, -2.0, 3.4)),
        target: turned(Vector3::new(-1.0, 2.0, 0.5), 40.0, Vector3::new(0.2, 0.1, 0.2)),
    }
}

/// What a tracker at `frames` reads of true platform poses, with its own noise.
fn seen_from(samples: &[Sample], truth: &[Pose], frames: &Frames, seed: u64) -> Dataset {
    use rand_distr::{Distribution, StandardNormal};
    let noise = paper_noise();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = |sd: f64| -> f64 {
        let z: f64 = StandardNormal.sample(&mut rng);
        sd * z
    };
    let (p, r) = (noise.position, noise.rotation);
    let readings = truth
        .iter()
        .map(|pose| {
            // A tracker's angular noise is a small turn; its angles are only the way to write the attitude down.
            let mut seen = frames.measured(pose);
            let turn = Vector3::new(normal(r), normal(r), normal(r));
            seen.rotation = Rotation3::from_scaled_axis(turn) * seen.rotation;
            seen.position += Vector3::new(normal(p), normal(p), normal(p));
            let values = PoseConvention::default().coordinates(&seen);
            PoseReading { values, measured: [true; 6], sigma: [p, p, p, r, r, r] }
        })
        .collect();
    Dataset::new(samples.to_vec(), Arc::new(PoseMeasurement::new(PoseConvention::default(), readings)), noise)
}

struct Case {
    nominal: Box<dyn Mechanism>,
    samples: Vec<Sample>,
    truth: Vec<Pose>,
    others: Vec<Sample>,
    other_truth: Vec<Pose>,
}

fn case() -> Case {
    let m = machine("table5");
    let nominal = m.mechanism;
    let real = true_mechanism(nominal.as_ref());
    let split = |name: &str| {
        let file = data(name, &machine("table5")).data;
        let samples: Vec<Sample> = file.iter().cloned().collect();
        let at = paracal::conditions::Conditions::unknown();
        let truth =
            samples.iter().map(|s| real.forward(real.values(), &s.joints, &at, &real.home()).unwrap()).collect();
        (samples, truth)
    };
    let (samples, truth) = split("hardpoint-exact");
    let (others, other_truth) = split("hardpoint-targets");
    Case { nominal, samples, truth, others, other_truth }
}

fn calibrated(case: &Case, frames: &Frames) -> Calibration {
    let data = seen_from(&case.samples, &case.truth, frames, 5);
    let space = workspace(case.nominal.as_ref(), 100.0, 10.0);
    let options = CalibrationOptions::default();
    calibrate(case.nominal.as_ref(), &data, Some(&space), &LevenbergMarquardt::default(), &options).unwrap()
}

#[test]
fn a_tracker_anywhere_calibrates_as_well_as_one_in_the_base_frame() {
    let case = case();
    let here = calibrated(&case, &Frames::default());
    assert!(!here.registration.applied && here.verdict.trusted);
    let none = Frames::default();
    let (here_p, here_r) = errors_of(here.mechanism.as_ref(), &seen_from(&case.others, &case.other_truth, &none, 6));
    // A skew axis, one that makes β exactly −90° in the tracker, and one turned upside down.
    for (axis, degrees) in [([0.3, -0.5, 0.8], 120.0), ([1.0, 1.0, 1.0], -120.0), ([1.0, 0.1, 0.0], 180.0)] {
        let frames = far_frames(Vector3::from(axis), degrees);
        let far = calibrated(&case, &frames);
        assert!(far.registration.applied && far.verdict.trusted, "{axis:?}: {:?}", far.verdict);
        assert!(far.plausibility.implausible.is_empty(), "{axis:?}: {:?}", far.plausibility.implausible);
        // The calibrated model is in the tracker's frame: it predicts other readings without any frame.
        let others = seen_from(&case.others, &case.other_truth, &frames, 6);
        let (p, r) = errors_of(far.mechanism.as_ref(), &others);
        // The positions are those of the target now, whose lever arm adds the model's attitude error.
        assert!(
            p < 1.15 * here_p && r < 1.15 * here_r,
            "{axis:?}: {p:.2e} {r:.2e}, in the base frame {here_p:.2e} {here_r:.2e}"
        );
        let held = far.held_out.unwrap().rms;
        assert!(held.position.unwrap() < 1.5 * here.held_out.unwrap().rms.position.unwrap());
        // The rigid motions are reported.
        let base = frames.base.motion_to(&far.plausibility.base);
        let target = frames.target.motion_to(&far.plausibility.target);
        assert!(base.amax() < 2e-3 && target.amax() < 2e-3, "{axis:?}: {base} {target}");
    }
}

#[test]
fn sigmas_are_carried_with_the_frames() {
    let case = case();
    let here = calibrated(&case, &Frames::default());
    // A quarter turn about z maps x to y and y to −x: so do the σ of the base points.
    let quarter = Frames { base: turned(Vector3::z(), 90.0, Vector3::new(1.0, 2.0, 3.0)), target: Pose::identity() };
    let far = calibrated(&case, &quarter);
    let sigma = |c: &Calibration, name: &str| c.parameters.iter().find(|p| p.spec.name == name).unwrap().sigma.unwrap();
    for leg in 1..=6 {
        for (before, after) in [("xB", "yB"), ("yB", "xB"), ("zB", "zB"), ("xA", "xA")] {
            let (a, b) = (sigma(&here, &format!("{before}{leg}")), sigma(&far, &format!("{after}{leg}")));
            assert!((a / b - 1.0).abs() < 0.02, "{before}{leg}: {a:.3e} {b:.3e}");
        }
    }
}

#[test]
fn small_workspaces_and_partial_readings_are_registered_too() {
    let m = machine("table5");
    let nominal = m.mechanism.as_ref();
    let real = true_mechanism(nominal);
    let space = workspace(nominal, 10.0, 0.5);
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let poses: Vec<Pose> = (0..40).map(|_| space.random(&mut rng)).collect();
    let run = simulate(nominal, real.as_ref(), &poses, &space.convention, &paper_noise(), &mut rng).unwrap();
    let plain = as_dataset(&run, &space.convention, &paper_noise());
    let samples: Vec<Sample> = plain.iter().cloned().collect();
    let truth: Vec<Pose> = run.iter().map(|s| s.truth).collect();
    let frames = far_frames(Vector3::new(0.2, 0.9, -0.4), 120.0);
    let far = seen_from(&samples, &truth, &frames, 9);
    let options = CalibrationOptions::default();
    let result = calibrate(nominal, &far, Some(&space), &LevenbergMarquardt::default(), &options).unwrap();
    assert!(result.verdict.trusted, "{:?}", result.verdict);
    assert!(result.plausibility.implausible.is_empty(), "{:?}", result.plausibility.implausible);
    let (p, _) = errors_of(result.mechanism.as_ref(), &far);
    assert!(p < 2e-6, "{p:.2e}");

    // Positions alone: one target at an unknown place, tracker anywhere.
    let readings = (0..far.len())
        .map(|k| {
            let pose = far.model().rigid_pose(k).unwrap();
            let q = PoseConvention::default().coordinates(&pose);
            let measured = [true, true, true, false, false, false];
            PoseReading { values: q, measured, sigma: [1e-6, 1e-6, 1e-6, 1.0, 1.0, 1.0] }
        })
        .collect();
    let points = PoseMeasurement::new(PoseConvention::default(), readings);
    let points = Dataset::new(samples, Arc::new(points), paper_noise());
    assert!(register(nominal, &points).applied);
    let result = calibrate(nominal, &points, Some(&space), &LevenbergMarquardt::default(), &options).unwrap();
    let held = result.held_out.unwrap().rms.position.unwrap();
    assert!(held < 4e-6, "{held:.2e}");
    assert!(result.verdict.trusted, "{:?}", result.verdict);
}

/// RMS over poses of a larger box of the position error over its predicted σ, for campaigns in small boxes whose
/// tracker and target stand where `frames` says; errors of the mechanism are drawn anew for each.
fn error_over_sigma(frames: &Frames, draws: u64) -> f64 {
    let m = machine("table5");
    let nominal = m.mechanism.as_ref();
    let (small, large) = (workspace(nominal, 10.0, 0.5), workspace(nominal, 50.0, 5.0));
    let at = paracal::conditions::Conditions::unknown();
    let ratios = paracal::simulation::monte_carlo(draws, 41, |k, rng| {
        let truth = nominal.with_values(&draw_parameters(nominal, None, rng), nominal.home()).unwrap();
        let poses: Vec<Pose> = (0..24).map(|_| small.random(rng)).collect();
        let run = simulate(nominal, truth.as_ref(), &poses, &small.convention, &paper_noise(), rng).unwrap();
        let samples: Vec<Sample> = as_dataset(&run, &small.convention, &paper_noise()).iter().cloned().collect();
        let went: Vec<Pose> = run.iter().map(|s| s.truth).collect();
        let data = seen_from(&samples, &went, frames, k);
        let options = CalibrationOptions { holdout: Holdout::None, ..CalibrationOptions::default() };
        let result = calibrate(nominal, &data, Some(&small), &LevenbergMarquardt::default(), &options).unwrap();
        assert!(result.verdict.trusted, "{:?}", result.verdict);
        let model = result.mechanism.as_ref();
        let ratio = |_: usize| {
            let joints = nominal.inverse(nominal.values(), &large.random(rng), &at).unwrap();
            let real = frames.measured(&truth.forward(truth.values(), &joints, &at, &nominal.home()).unwrap());
            let predicted = model.forward(model.values(), &joints, &at, &model.home()).unwrap();
            let spread = pose_covariance(model, &result.covariance, &joints, &predicted, &at).unwrap();
            let variance = spread.fixed_view::<3, 3>(0, 0).trace();
            (real.position - predicted.position).norm() / variance.sqrt()
        };
        common::rms((0..10).map(ratio))
    });
    common::rms(ratios)
}

#[test]
fn predicted_errors_hold_wherever_tracker_and_target_stand() {
    let shifted = Frames {
        base: turned(Vector3::new(0.2, -1.0, 0.4), 0.1, Vector3::new(0.002, -0.001, 0.002)),
        target: turned(Vector3::new(1.0, 0.3, -0.2), 0.1, Vector3::new(-0.001, 0.002, 0.001)),
    };
    let far = far_frames(Vector3::new(0.2, 0.9, -0.4), 120.0);
    let tracker_only = Frames { base: far.base, target: Pose::identity() };
    for (name, frames) in
        [("base frame", Frames::default()), ("a little off", shifted), ("far", far), ("tracker only", tracker_only)]
    {
        let ratio = error_over_sigma(&frames, 30);
        // Thirty campaigns of a dozen poorly known directions each; too small a ratio is caution, too large a lie.
        assert!((0.6..1.25).contains(&ratio), "{name}: {ratio:.3}");
    }
}

#[test]
fn a_pivot_is_the_point_that_positions_state() {
    use paracal::pose::RotationOrder;
    let m = machine("table5");
    let nominal = m.mechanism.as_ref();
    let real = true_mechanism(nominal);
    let pivot = Vector3::new(0.05, -0.03, -2.7);
    let convention = PoseConvention { order: RotationOrder::Xyz, pivot };
    let space = workspace(nominal, 100.0, 10.0);
    let mut rng = ChaCha8Rng::seed_from_u64(51);
    let poses: Vec<Pose> = (0..60).map(|_| space.random(&mut rng)).collect();
    let run = simulate(nominal, real.as_ref(), &poses, &convention, &paper_noise(), &mut rng).unwrap();
    let (p, r) = (1e-6, 1e-4_f64.to_radians());
    for missing in [vec![], vec![3, 4, 5], vec![5]] {
        let mut measured = [true; 6];
        missing.iter().for_each(|k| measured[*k] = false);
        let reading = |s: &paracal::simulation::SimulatedSample| PoseReading {
            values: s.measured,
            measured,
            sigma: [p, p, p, r, r, r],
        };
        let model = PoseMeasurement::new(convention, run.iter().map(reading).collect());
        let samples: Vec<Sample> = as_dataset(&run, &convention, &paper_noise()).iter().cloned().collect();
        let data = Dataset::new(samples, Arc::new(model), paper_noise());
        assert!(!register(nominal, &data).applied, "without {missing:?}");
        let options = CalibrationOptions::default();
        let result = calibrate(nominal, &data, Some(&space), &LevenbergMarquardt::default(), &options).unwrap();
        assert!(result.verdict.trusted, "without {missing:?}: {:?}", result.verdict);
        let held = result.held_out.unwrap().rms.position.unwrap();
        // A 2.7 m arm carries the attitude's error into the position.
        assert!(held < 8e-6, "without {missing:?}: {held:.2e}");
    }
}
