//! Readings other than full poses: the model that they give predicts other poses as well as its covariance says.

use std::sync::Arc;

use crate::common::campaign::{Campaign, campaign, held_out_over_predicted};
use crate::common::{machine, paper_noise, rms};
use paracal::conditions::Conditions;
use paracal::files::read_measurement;
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, calibrate, pose_covariance};
use paracal::measurement::{
    Dataset, Frames, MeasurementModel, Noise, PoseMeasurement, PoseReading, Rows, Sample, TargetMeasurement,
    TargetPoint,
};
use paracal::nalgebra::{Matrix3x6, Vector3};
use paracal::pose::{Pose, PoseConvention, RotationOrder};
use paracal::simulation::SimulatedSample;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

fn partial(c: &Campaign, measured: [bool; 6]) -> Dataset {
    let (p, r) = (1e-6, 1e-4_f64.to_radians());
    let reading = |s: &SimulatedSample| PoseReading { values: s.measured, measured, sigma: [p, p, p, r, r, r] };
    let model = PoseMeasurement::new(c.space.convention, c.run.iter().map(reading).collect());
    Dataset::new(c.samples.clone(), Arc::new(model), paper_noise())
}

/// RMS over other poses of the error of `point` on the platform over its predicted σ.
fn error_over_sigma(c: &Campaign, data: &Dataset, point: &Vector3<f64>) -> f64 {
    let options = CalibrationOptions::default();
    let identifier = LevenbergMarquardt::default();
    let result = calibrate(c.nominal.as_ref(), data, Some(&c.space), &identifier, &options).unwrap();
    assert!(result.verdict.trusted, "{:?}", result.verdict);
    let at = Conditions::unknown();
    let mut rng = ChaCha8Rng::seed_from_u64(22);
    let model = result.mechanism.as_ref();
    let mut ratios = Vec::new();
    for _ in 0..300 {
        let wanted = c.space.random(&mut rng);
        let joints = model.inverse(model.values(), &wanted, &at).unwrap();
        let reached = c.truth.forward(c.truth.values(), &joints, &at, &wanted).unwrap();
        let spread = pose_covariance(model, &result.covariance, &joints, &wanted, &at).unwrap();
        let mut seen = Matrix3x6::zeros();
        seen.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
        seen.fixed_view_mut::<3, 3>(0, 3).copy_from(&-(wanted.rotation * point).cross_matrix());
        let miss = reached.place(point) - wanted.place(point);
        let sigma = (seen * spread * seen.transpose()).trace().sqrt();
        ratios.push(miss.norm() / sigma);
    }
    rms(ratios)
}

#[test]
fn positions_alone_predict_positions() {
    let c = campaign(60);
    let data = partial(&c, [true, true, true, false, false, false]);
    let ratio = error_over_sigma(&c, &data, &Vector3::zeros());
    // One campaign has a few dozen effective directions, so the ratio scatters by about 20 %.
    assert!((0.5..1.6).contains(&ratio), "{ratio:.3}");
}

#[test]
fn one_missing_coordinate_is_no_obstacle() {
    let c = campaign(40);
    for missing in [0, 2, 5] {
        let mut measured = [true; 6];
        measured[missing] = false;
        let ratio = error_over_sigma(&c, &partial(&c, measured), &Vector3::zeros());
        assert!((0.5..1.6).contains(&ratio), "coordinate {missing}: {ratio:.3}");
    }
}

#[test]
fn held_out_rows_err_as_the_covariance_says() {
    let c = campaign(260);
    let (p, r) = ([true; 3], [true; 3]);
    let mut cases: Vec<(String, Dataset)> =
        vec![("positions".into(), partial(&c, [true, true, true, false, false, false]))];
    for missing in 0..6 {
        let mut measured = [p, r].concat();
        measured[missing] = false;
        cases.push((format!("without {missing}"), partial(&c, measured.try_into().unwrap())));
    }
    for known in [true, false] {
        cases.push((format!("targets, known {known}"), target_data(&c, known, &Pose::identity()).0));
    }
    for (name, data) in cases {
        let ratio = held_out_over_predicted(&c, &data, 60);
        // 600 to 1800 rows whose model errors are correlated.
        assert!((0.85..1.15).contains(&ratio), "{name}: {ratio:.3}");
    }
}

const TARGETS: [[f64; 3]; 3] = [[1.3, 0.0, 0.08], [-0.6, 1.1, 0.08], [-0.6, -1.1, 0.10]];

fn target_data(c: &Campaign, known: bool, moved: &Pose) -> (Dataset, Arc<TargetMeasurement>) {
    let mut rng = ChaCha8Rng::seed_from_u64(23);
    let mut noise = || -> f64 {
        let z: f64 = StandardNormal.sample(&mut rng);
        1e-6 * z
    };
    let targets = TARGETS.iter().enumerate().map(|(k, t)| TargetPoint {
        name: format!("p{}", k + 1),
        platform: known.then(|| Vector3::from_column_slice(t)),
    });
    let mut row = |s: &SimulatedSample| -> Vec<[Option<f64>; 3]> {
        let place = |t: &[f64; 3]| moved.place(&s.truth.place(&Vector3::from_column_slice(t)));
        TARGETS.iter().map(|t| [0, 1, 2].map(|k| Some(place(t)[k] + noise()))).collect()
    };
    let readings = c.run.iter().map(&mut row).collect();
    let model = Arc::new(TargetMeasurement::new(targets.collect(), readings, vec![[1e-6; 3]; c.run.len()]));
    (Dataset::new(c.samples.clone(), model.clone(), Noise::stated(1e-6, 1e-6)), model)
}

#[test]
fn three_targets_at_unknown_places_predict_the_targets() {
    let c = campaign(30);
    for known in [true, false] {
        let (data, model) = target_data(&c, known, &Pose::identity());
        assert_eq!(model.nuisance_parameters().len(), if known { 0 } else { 9 });
        let options = CalibrationOptions::default();
        let identifier = LevenbergMarquardt::default();
        let result = calibrate(c.nominal.as_ref(), &data, Some(&c.space), &identifier, &options).unwrap();
        assert!(result.verdict.trusted, "{:?}", result.verdict);
        // The readings of other poses are predicted to the noise and little more.
        let held = result.held_out.unwrap().rms.position.unwrap();
        assert!(held < 2.2 * 1.732e-6, "known {known}: {held:.2e}");
        // Unknown places are only known together with the platform frame, which the tolerances hold.
        assert_eq!(result.identification.prior, !known);
        let found = model.located(&result.identification.own_values());
        for (t, place) in found.iter().zip(TARGETS) {
            assert!((t.platform.unwrap() - Vector3::from_column_slice(&place)).norm() < 2e-3, "{t:?}");
        }
    }
    let (data, _) = target_data(&c, true, &Pose::identity());
    let ratio = error_over_sigma(&c, &data, &Vector3::zeros());
    assert!((0.5..1.6).contains(&ratio), "{ratio:.3}");
}

#[test]
fn targets_are_found_from_a_tracker_elsewhere() {
    let c = campaign(30);
    let tracker = Pose::from_coordinates(&[4.0, -3.0, 1.0, 2.0, 0.4, -1.5]);
    for known in [true, false] {
        let (data, _) = target_data(&c, known, &tracker);
        let options = CalibrationOptions::default();
        let identifier = LevenbergMarquardt::default();
        let result = calibrate(c.nominal.as_ref(), &data, Some(&c.space), &identifier, &options).unwrap();
        assert!(result.registration.applied && result.verdict.trusted, "{:?}", result.verdict);
        assert!(result.after.position.unwrap() < 2e-6, "known {known}: {:?}", result.after);
        assert!(result.plausibility.implausible.is_empty(), "{:?}", result.plausibility.implausible);
    }
}

#[test]
fn quaternions_sigmas_and_commanded_poses_are_read() {
    let c = campaign(3);
    let m = machine("table5");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("data.csv");
    let mut text = String::from("# a comment\nid,cmd_x_mm,cmd_y_mm,cmd_z_mm,cmd_rx_deg,cmd_ry_deg,cmd_rz_deg,");
    text += "x_mm,y_mm,z_in,qw,qx,qy,qz,sigma_x_um,sigma_rx_arcsec,temp_legs_degC,spindle,remark\n";
    for (k, s) in c.run.iter().enumerate() {
        let wanted =
            c.nominal.forward(c.nominal.values(), &s.joints, &Conditions::unknown(), &c.nominal.home()).unwrap();
        let w = wanted.coordinates();
        let pose = Pose::from_coordinates(&s.measured);
        let q = pose.to_isometry().rotation;
        let p = 1e3 * pose.position;
        text += &format!("row {k},{},{},{},", 1e3 * w[0], 1e3 * w[1], 1e3 * w[2]);
        text += &format!("{},{},{},", w[3].to_degrees(), w[4].to_degrees(), w[5].to_degrees());
        text += &format!("{},{},{},{},{},{},{},2,0.5,21.5,{k},fine\n", p.x, p.y, p.z / 25.4, q.w, q.i, q.j, q.k);
    }
    std::fs::write(&file, text).unwrap();
    let read = read_measurement(&file, &m).unwrap();
    assert!(read.warnings.iter().any(|w| w.contains("remark")), "{:?}", read.warnings);
    for (k, s) in c.run.iter().enumerate() {
        let sample = read.data.sample(k);
        assert_eq!(sample.id.as_deref(), Some(format!("row {k}").as_str()));
        for (a, b) in sample.joints.iter().zip(&s.joints) {
            assert!((a - b).abs() < 1e-12);
        }
        assert_eq!(sample.conditions.get("temp_legs"), Some(21.5));
        assert_eq!(sample.conditions.get("spindle"), Some(k as f64));
        let pose = read.data.model().rigid_pose(k).unwrap();
        assert!(pose.motion_to(&Pose::from_coordinates(&s.measured)).amax() < 1e-12);
        let covariance = read.data.model().covariance(k, &read.data.frames);
        assert!((covariance[(0, 0)].sqrt() - 2e-6).abs() < 1e-15 && (covariance[(1, 1)].sqrt() - 1e-6).abs() < 1e-15);
        assert!((covariance[(3, 3)].sqrt().to_degrees() * 3600.0 - 0.5).abs() < 1e-12);
    }
}

/// The same attitude written as other angles: with a full turn more, and as the other triple of Euler angles.
#[test]
fn an_attitude_has_one_answer_however_it_is_written() {
    use std::f64::consts::{PI, TAU};
    let sigma = [1e-6, 1e-6, 1e-6, 1e-5, 3e-5, 9e-5];
    let stated = [0.02, -0.01, 0.4, 0.11, -0.07, 0.23];
    let other = [0.02, -0.01, 0.4, 0.11 + PI, PI + 0.07, 0.23 - PI];
    let turned = [0.02, -0.01, 0.4, 0.11 + TAU, -0.07 - TAU, 0.23 + 2.0 * TAU];
    for order in [RotationOrder::Zyx, RotationOrder::Xyz] {
        let convention = PoseConvention { order, ..PoseConvention::default() };
        let reading = |values: [f64; 6]| PoseReading { values, measured: [true; 6], sigma };
        let model = PoseMeasurement::new(convention, vec![reading(stated), reading(other), reading(turned)]);
        let mut at = stated;
        at[4] += 1e-3;
        let pose = convention.pose(&at);
        let tilted = Frames {
            base: convention.pose(&[1.0, 2.0, 3.0, 0.4, 0.5, 0.6]),
            target: convention.pose(&[0.1, 0.0, 0.2, 0.1, 0.2, 0.3]),
        };
        for frames in [Frames::default(), tilted] {
            let rows = |k: usize| {
                let mut rows = Rows::sized(6, 0);
                model.evaluate(k, &Sample::default(), &pose, &frames, &[], &mut rows);
                (rows.residual, rows.motion, model.covariance(k, &frames))
            };
            let (residual, motion, covariance) = rows(0);
            for k in [1, 2] {
                let other = rows(k);
                assert!((&other.0 - &residual).amax() < 1e-12, "{order:?}: {} {}", other.0, residual);
                assert!((&other.1 - &motion).amax() < 1e-12 && (&other.2 - &covariance).amax() < 1e-20);
            }
        }
    }
}
