//! Machines that the drawing does not lead to: near a singularity, with more joints than they need, beyond reach.

use std::f64::consts::TAU;

use nalgebra::{Rotation3, Vector3};
use paracal::identification::{Calibration, CalibrationOptions, Holdout, LevenbergMarquardt, calibrate};
use paracal::measurement::{DataRow, Dataset, Noise, PoseMeasurement, Sample};
use paracal::mechanism::{Leg, Mechanism, SixHardpoint, Workspace};
use paracal::pose::{Pose, PoseConvention};
use paracal::simulation::{as_dataset, draw_parameters, simulate};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

use crate::common::machine;

/// σ of anchors and lengths, m.
const TOLERANCE: f64 = 0.5e-3;
const POSES: usize = 30;

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// Points on a circle, 60° apart, each a little off its place.
fn circle(radius: f64, turn: f64, z: f64, rng: &mut ChaCha8Rng) -> Vec<Vector3<f64>> {
    let point = |k: usize| {
        let angle = TAU * k as f64 / 6.0 + turn + 0.05 * normal(rng);
        let r = radius * (1.0 + 0.05 * normal(rng));
        Vector3::new(r * angle.cos(), r * angle.sin(), z + 0.02 * radius * normal(rng))
    };
    (0..6).map(point).collect()
}

/// Determinant of the lines of the legs at a pose; it changes its sign where the legs do not hold the platform.
fn determinant(c: &[f64], pose: &Pose) -> f64 {
    let rows = nalgebra::Matrix6::from_fn(|leg, k| {
        let c = &c[7 * leg..7 * leg + 7];
        let arm = pose.rotation * Vector3::new(c[0], c[1], c[2]);
        let line = (pose.position + arm - Vector3::new(c[4], c[5], c[6])).normalize();
        if k < 3 { line[k] } else { arm.cross(&line)[k - 3] }
    });
    rows.determinant()
}

/// A machine whose six legs are twisted one way, so that they hardly hold the platform against a turn, and data of one that
/// was built to its tolerances. Lengths are computed here.
fn twisted(rng: &mut ChaCha8Rng) -> Option<(SixHardpoint, Vec<f64>, Dataset, Workspace)> {
    let base = circle(0.5, 0.0, 0.0, rng);
    let platform = circle(0.35, rng.random_range(72.0_f64..84.0).to_radians(), 0.0, rng);
    let home = Pose { position: Vector3::new(0.0, 0.0, 0.45), rotation: Rotation3::identity() };
    let length = |a: &Vector3<f64>, b: &Vector3<f64>, pose: &Pose| (pose.position + pose.rotation * a - b).norm();
    let legs: Vec<Leg> = platform
        .iter()
        .zip(&base)
        .map(|(a, b)| Leg { platform: *a, base: *b, length: length(a, b, &home), length_offset: 0.0, stroke: None })
        .collect();
    let nominal = SixHardpoint::new("twisted", &legs, Some(home), Some((TOLERANCE, TOLERANCE))).unwrap();
    let truth: Vec<f64> = nominal.values().iter().map(|v| v + TOLERANCE * normal(rng)).collect();
    let noise = Noise::stated(2e-6, 2e-6);
    let convention = PoseConvention::default();
    let half = [0.01, 0.01, 0.01, 0.01, 0.01, 0.01];
    let space = Workspace { convention, centre: convention.coordinates(&home), half };
    let (mut samples, mut poses) = (Vec::new(), Vec::new());
    let side = determinant(nominal.values(), &home);
    for row in 0..POSES {
        let pose = space.random(rng);
        // The real machine stays on its side of the singularity.
        if determinant(&truth, &pose) / side < 0.05 {
            return None;
        }
        // h of a leg is its length less the offset: a, length, b in the order of the parameters.
        let joints = truth.chunks(7).zip(&legs).map(|(c, leg)| {
            let (a, b) = (Vector3::new(c[0], c[1], c[2]), Vector3::new(c[4], c[5], c[6]));
            length(&a, &b, &pose) - (c[3] - leg.length)
        });
        samples.push(Sample { row: DataRow(row), joints: joints.collect(), ..Sample::default() });
        let mut q = convention.coordinates(&pose);
        q.iter_mut().for_each(|v| *v += 2e-6 * normal(rng));
        poses.push(convention.pose(&q));
    }
    let model = PoseMeasurement::full(convention, &poses, noise.position, noise.rotation);
    Some((nominal, truth, Dataset::new(samples, std::sync::Arc::new(model), noise), space))
}

fn calibrated(mechanism: &dyn Mechanism, data: &Dataset, space: Option<&Workspace>) -> Option<Calibration> {
    let options = CalibrationOptions { holdout: Holdout::None, ..CalibrationOptions::default() };
    calibrate(mechanism, data, space, &LevenbergMarquardt::default(), &options).ok()
}

#[test]
fn honest_data_of_machines_near_a_singularity_are_calibrated() {
    let (mut trusted, mut beyond, mut squares) = (0, 0, Vec::new());
    for seed in 0..40 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (nominal, truth, data, space) = (0..1000).find_map(|_| twisted(&mut rng)).unwrap();
        let Some(found) = calibrated(&nominal, &data, Some(&space)) else {
            continue;
        };
        trusted += usize::from(found.verdict.trusted);
        beyond += usize::from(found.not_reached > 0);
        let z = found.identification.parameters.iter().zip(&truth).map(|(p, t)| (p.value - t) / p.sigma.unwrap());
        let z: Vec<f64> = z.map(|z| z * z).collect();
        squares.extend(z);
    }
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    assert!(beyond > 5, "only {beyond} of the machines are not reached from their drawing");
    assert!(trusted >= 38 && (0.9..1.15).contains(&mean), "{trusted} of 40, mean z² {mean:.3}, {beyond} beyond reach");
}

#[test]
fn joints_that_contradict_each_other_converge() {
    let machine = machine("planar-cables");
    let (nominal, space) = (machine.mechanism.as_ref(), machine.workspace.unwrap());
    let noise = Noise { joint: 0.5_f64.to_radians(), ..Noise::stated(0.2e-3, 0.02_f64.to_radians()) };
    let mut failed = Vec::new();
    for seed in 0..40 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let values = draw_parameters(nominal, Some(2e-3), &mut rng);
        let truth = nominal.with_values(&values, nominal.home()).unwrap();
        let poses: Vec<Pose> = (0..60).map(|_| space.random(&mut rng)).collect();
        let run = simulate(nominal, truth.as_ref(), &poses, &space.convention, &noise, &mut rng).unwrap();
        match calibrated(nominal, &as_dataset(&run, &space.convention, &noise), Some(&space)) {
            Some(found) if found.converged && found.verdict.trusted => {}
            Some(found) => failed.push(format!("{seed}: {:?}", found.verdict.reasons)),
            None => failed.push(format!("{seed}: no result")),
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
