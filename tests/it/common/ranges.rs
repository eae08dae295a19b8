//! A kind of measurement from outside the crate: ranges from fixed stations to points of the platform, as a
//! multilateration system reports them, with an offset of the range meter that is identified.

use paracal::measurement::{Frames, MeasurementModel, PointReading, RowKind, Rows, Sample};
use paracal::mechanism::{ParameterRole, ParameterSpec};
use paracal::nalgebra::{DMatrix, Vector3};
use paracal::pose::Pose;
use paracal::units::Dimension;

pub const SIGMA: f64 = 1e-6;
pub const OFFSET: f64 = 0.3e-3;

#[derive(Debug)]
pub struct Ranges {
    stations: Vec<Vector3<f64>>,
    points: Vec<Vector3<f64>>,
    /// By sample, then by station and point.
    readings: Vec<Vec<f64>>,
    own: [ParameterSpec; 1],
    /// A mistake to be caught: the sign of the turn about x.
    pub wrong_sign: bool,
}

impl Ranges {
    /// Four stations and three points, nothing measured yet.
    pub fn new() -> Self {
        let stations = [[4.0, 0.5, 2.0], [-2.0, 3.5, 3.0], [-1.5, -3.0, 0.5], [0.5, 0.2, 5.0]].map(Vector3::from);
        let points = [[1.3, 0.0, 0.1], [-0.6, 1.1, 0.1], [-0.6, -1.1, 0.15]].map(Vector3::from);
        let offset = ParameterSpec {
            name: "offset".into(),
            dimension: Dimension::Length,
            nominal: 0.0,
            tolerance: None,
            role: ParameterRole::Other,
        };
        let (stations, points) = (stations.into(), points.into());
        Self { stations, points, readings: Vec::new(), own: [offset], wrong_sign: false }
    }

    /// Measures the ranges at these poses; `normal` draws normal numbers.
    pub fn measure(&mut self, poses: impl Iterator<Item = Pose>, mut normal: impl FnMut() -> f64) {
        let mut range = |pose: &Pose, (s, p): (&Vector3<f64>, &Vector3<f64>)| {
            (pose.place(p) - s).norm() + OFFSET + SIGMA * normal()
        };
        self.readings = poses.map(|pose| self.pairs().map(|pair| range(&pose, pair)).collect()).collect();
    }

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
    fn nuisance_parameters(&self) -> &[ParameterSpec] {
        &self.own
    }
    fn evaluate(&self, index: usize, _: &Sample, pose: &Pose, frames: &Frames, own: &[f64], out: &mut Rows) {
        for (row, ((station, point), measured)) in self.pairs().zip(&self.readings[index]).enumerate() {
            let arm = pose.rotation * point;
            let sight = frames.base.place(&(pose.position + arm)) - station;
            let along = frames.base.rotation.inverse() * sight.normalize();
            let mut turn = arm.cross(&along);
            if self.wrong_sign {
                turn.x = -turn.x;
            }
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
