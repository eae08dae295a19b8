//! A kind of measurement from outside the crate: ranges from fixed stations to points of the platform, as a
//! multilateration system reports them, with an offset of the range meter that is identified.
#![allow(clippy::unwrap_used)]

mod common;

use std::sync::Arc;

use common::{machine, paper_noise, true_mechanism, workspace};
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, calibrate};
use paracal::measurement::{Dataset, Frames, MeasurementModel, Noise, PointReading, RowKind, Rows, Sample};
use paracal::mechanism::{ParameterRole, ParameterSpec};
use paracal::nalgebra::{DMatrix, Vector3};
use paracal::pose::Pose;
use paracal::simulation::simulate;
use paracal::units::Dimension;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const SIGMA: f64 = 1e-6;
const OFFSET: f64 = 0.3e-3;

#[derive(Debug)]
struct Ranges {
    stations: Vec<Vector3<f64>>,
    points: Vec<Vector3<f64>>,
    /// By sample, then by station and point.
    readings: Vec<Vec<f64>>,
    own: [ParameterSpec; 1],
}

impl Ranges {
    fn pairs(&self) -> impl Iterator<Item = (&Vector3<f64>, &Vector3<f64>)> {
        self.stations.iter().flat_map(|s| self.points.iter().map(move |p| (s, p)))
    }
}

impl MeasurementModel for Ranges {
    fn describe(&self) -> String {
        "ranges".into()
    }
    fn samples(&self) -> usize {
        self.readings.len()
    }
    fn rows(&self, _sample: usize) -> Vec<RowKind> {
        vec![RowKind::Position; self.pairs().count()]
    }
    fn own_parameters(&self) -> &[ParameterSpec] {
        &self.own
    }
    fn evaluate(&self, sample: usize, pose: &Pose, frames: &Frames, own: &[f64], out: &mut Rows) {
        for (row, ((station, point), measured)) in self.pairs().zip(&self.readings[sample]).enumerate() {
            let arm = pose.rotation * point;
            let sight = frames.base.place(&(pose.position + arm)) - station;
            let along = frames.base.rotation.inverse() * sight.normalize();
            let turn = arm.cross(&along);
            out.residual[row] = sight.norm() + own[0] - measured;
            for k in 0..3 {
                out.motion[(row, k)] = along[k];
                out.motion[(row, k + 3)] = turn[k];
            }
            out.own[(row, 0)] = 1.0;
        }
    }
    fn covariance(&self, _sample: usize, _frames: &Frames) -> DMatrix<f64> {
        let k = self.pairs().count();
        DMatrix::from_diagonal_element(k, k, SIGMA * SIGMA)
    }
    fn rigid_pose(&self, _sample: usize) -> Option<Pose> {
        None
    }
    fn point(&self, _sample: usize) -> Option<PointReading> {
        None
    }
}

#[test]
fn ranges_calibrate_the_mechanism_and_their_own_offset() {
    let m = machine("table5");
    let nominal = m.mechanism.as_ref();
    let truth = true_mechanism(nominal);
    let space = workspace(nominal, 100.0, 10.0);
    let mut rng = ChaCha8Rng::seed_from_u64(61);
    let poses: Vec<Pose> = (0..40).map(|_| space.random(&mut rng)).collect();
    let run = simulate(nominal, truth.as_ref(), &poses, &space.convention, &paper_noise(), &mut rng).unwrap();
    let stations = [[4.0, 0.5, 2.0], [-2.0, 3.5, 3.0], [-1.5, -3.0, 0.5], [0.5, 0.2, 5.0]].map(Vector3::from);
    let points = [[1.3, 0.0, 0.1], [-0.6, 1.1, 0.1], [-0.6, -1.1, 0.15]].map(Vector3::from);
    let offset = ParameterSpec {
        name: "offset".into(),
        dimension: Dimension::Length,
        nominal: 0.0,
        tolerance: None,
        role: ParameterRole::Other,
    };
    let mut model = Ranges { stations: stations.into(), points: points.into(), readings: Vec::new(), own: [offset] };
    let mut range = |pose: &Pose, (s, p): (&Vector3<f64>, &Vector3<f64>)| {
        let noise: f64 = StandardNormal.sample(&mut rng);
        (pose.place(p) - s).norm() + OFFSET + SIGMA * noise
    };
    let readings = run.iter().map(|sample| model.pairs().map(|pair| range(&sample.truth, pair)).collect()).collect();
    model.readings = readings;
    let samples = run.iter().enumerate().map(|(row, s)| Sample { row, joints: s.joints.clone(), ..Sample::default() });
    let data = Dataset::new(samples.collect(), Arc::new(model), Noise::stated(SIGMA, SIGMA));
    let options = CalibrationOptions::default();
    let result = calibrate(nominal, &data, Some(&space), &LevenbergMarquardt::default(), &options).unwrap();
    assert!(result.verdict.trusted, "{:?}", result.verdict);
    let found = result.parameters.last().unwrap();
    let (error, sigma) = ((found.value - OFFSET).abs(), found.sigma.unwrap());
    assert!(found.spec.name == "offset" && error < 4.0 * sigma && sigma < 2e-6, "{error:.2e} {sigma:.2e}");
    for (p, t) in result.parameters.iter().zip(truth.values()) {
        assert!((p.value - t).abs() < 4.5 * p.sigma.unwrap(), "{}: {} {t}", p.spec.name, p.value);
    }
}
