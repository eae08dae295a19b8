//! Measured positions of points on the platform.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::pose_measurement::point_motion;
use super::{Frames, MeasurementModel, PointReading, RowKind, Rows, Sample, TargetFrame, numbered};
use crate::mechanism::{Axis, ParameterRole, ParameterSpec};
use crate::pose::{Pose, fit_rigid_motion};
use crate::units::Dimension;

/// A point of the platform that is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetPoint {
    /// Name in the file: `p1`.
    pub name: String,
    /// Where it is, platform frame, m; `None` if that is to be identified.
    pub platform: Option<Vector3<f64>>,
}

/// Positions of targets, m, in the tracker's frame; coordinates may be missing.
///
/// Targets whose place on the platform is not known add three own parameters each. The platform frame is then
/// held by the tolerances of the platform points alone: turning it with all platform points and targets
/// changes no reading.
#[derive(Clone, Debug)]
pub struct TargetMeasurement {
    targets: Vec<TargetPoint>,
    /// By sample, then by target.
    readings: Vec<Vec<[Option<f64>; 3]>>,
    /// 1σ of each coordinate, by sample, then by target.
    sigma: Vec<Vec<[f64; 3]>>,
    own: Vec<ParameterSpec>,
}

impl TargetMeasurement {
    /// Readings by sample and target, with 1σ (m) of the coordinates of each sample.
    ///
    /// # Panics
    /// If the two have not the same number of samples, which is a mistake of the caller.
    pub fn new(targets: Vec<TargetPoint>, readings: Vec<Vec<[Option<f64>; 3]>>, sigma: Vec<[f64; 3]>) -> Self {
        let each = sigma.into_iter().map(|sigma| vec![sigma; targets.len()]).collect();
        Self::with_sigma_of_each(targets, readings, each)
    }

    /// The same with 1σ (m) of every reading, by sample and target: a target that is farther from the instrument is seen
    /// less well.
    ///
    /// # Panics
    /// If the two have not the same numbers of samples and targets, which is a mistake of the caller.
    #[allow(clippy::panic)]
    pub fn with_sigma_of_each(
        targets: Vec<TargetPoint>,
        readings: Vec<Vec<[Option<f64>; 3]>>,
        sigma: Vec<Vec<[f64; 3]>>,
    ) -> Self {
        assert_eq!(readings.len(), sigma.len(), "one set of sigma for each sample");
        assert!(readings.iter().zip(&sigma).all(|(r, s)| r.len() == s.len()), "one set of sigma for each target");
        let spec = |name: &str, axis: Axis| ParameterSpec {
            name: format!("{name}{}", ["x", "y", "z"][axis.index()]),
            dimension: Dimension::Length,
            nominal: f64::NAN,
            tolerance: None,
            role: ParameterRole::Other,
        };
        let unknown = targets.iter().filter(|t| t.platform.is_none());
        let own = unknown.flat_map(|t| Axis::ALL.map(|axis| spec(&t.name, axis))).collect();
        Self { targets, readings, sigma, own }
    }

    /// The targets, with the identified coordinates put in.
    pub fn located(&self, own: &[f64]) -> Vec<TargetPoint> {
        self.places(own)
            .into_iter()
            .zip(&self.targets)
            .map(|(place, t)| TargetPoint { name: t.name.clone(), platform: Some(place) })
            .collect()
    }

    /// Place of each target on the platform.
    fn places(&self, own: &[f64]) -> Vec<Vector3<f64>> {
        let mut rest = own.chunks_exact(3);
        let next = |t: &TargetPoint| {
            t.platform.unwrap_or_else(|| rest.next().map_or(Vector3::zeros(), Vector3::from_column_slice))
        };
        self.targets.iter().map(next).collect()
    }

    fn known(&self) -> usize {
        self.targets.iter().filter(|t| t.platform.is_some()).count()
    }

    /// The targets of a sample whose three coordinates were measured.
    fn complete(&self, sample: usize) -> impl Iterator<Item = (usize, Vector3<f64>)> + '_ {
        self.readings[sample].iter().enumerate().filter_map(|(t, r)| Some((t, Vector3::new(r[0]?, r[1]?, r[2]?))))
    }
}

/// Singular values below this, m, say that the places lie on a line.
const COLLINEAR: f64 = 1e-9;

impl MeasurementModel for TargetMeasurement {
    fn describe(&self) -> String {
        let unknown = self.own.len() / 3;
        let n = self.targets.len();
        match unknown {
            0 => format!("{n} target points"),
            _ => format!("{n} target points, {unknown} of them at unknown places on the platform"),
        }
    }

    fn samples(&self) -> usize {
        self.readings.len()
    }

    fn rows(&self, sample: usize) -> Vec<RowKind> {
        vec![RowKind::Position; self.readings[sample].iter().flatten().flatten().count()]
    }

    fn row_of_each(&self, sample: usize) -> Vec<Option<usize>> {
        numbered(self.readings[sample].iter().flatten().map(Option::is_some))
    }

    fn nuisance_parameters(&self) -> &[ParameterSpec] {
        &self.own
    }

    fn nuisance_heading(&self) -> &'static str {
        "Identified target coordinates"
    }

    fn start(&self, poses: &[Option<Pose>], frames: &Frames) -> Vec<f64> {
        let mut start = Vec::with_capacity(self.own.len());
        for (t, _) in self.targets.iter().enumerate().filter(|(_, t)| t.platform.is_none()) {
            let (mut sum, mut count) = (Vector3::zeros(), 0.0);
            for (sample, pose) in poses.iter().enumerate().filter_map(|(k, p)| Some((k, p.as_ref()?))) {
                if let Some((_, p)) = self.complete(sample).find(|(k, _)| *k == t) {
                    sum += pose.inverse().place(&frames.base.inverse().place(&p));
                    count += 1.0;
                }
            }
            start.extend((sum / f64::max(count, 1.0)).iter());
        }
        start
    }

    fn evaluate(&self, index: usize, _sample: &Sample, pose: &Pose, frames: &Frames, own: &[f64], out: &mut Rows) {
        let turn = frames.base.rotation.matrix();
        let (mut row, mut unknown) = (0, 0);
        for ((target, place), reading) in self.targets.iter().zip(self.places(own)).zip(&self.readings[index]) {
            let point = frames.base.place(&pose.place(&place));
            let motion = turn * point_motion(pose, &place);
            let along = turn * pose.rotation.matrix();
            for (k, measured) in reading.iter().enumerate() {
                let Some(measured) = measured else { continue };
                out.residual[row] = point[k] - measured;
                out.motion.row_mut(row).copy_from(&motion.row(k));
                if target.platform.is_none() {
                    out.own.view_mut((row, 3 * unknown), (1, 3)).copy_from(&along.row(k));
                }
                row += 1;
            }
            unknown += usize::from(target.platform.is_none());
        }
    }

    fn covariance(&self, sample: usize, _frames: &Frames) -> DMatrix<f64> {
        let each = self.readings[sample].iter().flatten().zip(self.sigma[sample].iter().flatten());
        let variances: Vec<f64> = each.filter(|(seen, _)| seen.is_some()).map(|(_, s)| s.powi(2)).collect();
        DMatrix::from_diagonal(&DVector::from_vec(variances))
    }

    fn target_frame(&self) -> TargetFrame {
        if self.known() >= 3 || self.own.is_empty() { TargetFrame::Known } else { TargetFrame::Identified }
    }

    /// The best rigid motion of the identified places, where all are.
    fn platform_motion(&self, own: &[f64], pose: &Pose, _frames: &Frames) -> Option<DMatrix<f64>> {
        let n = self.targets.len();
        if n < 3 || self.known() > 0 {
            return None;
        }
        let mut moved = DMatrix::zeros(3 * n, 6);
        for (t, place) in self.places(own).iter().enumerate() {
            moved.fixed_view_mut::<3, 3>(3 * t, 0).copy_from(&Matrix3::identity());
            moved.fixed_view_mut::<3, 3>(3 * t, 3).copy_from(&-place.cross_matrix());
        }
        let mut motion = moved.pseudo_inverse(COLLINEAR).ok()?;
        for mut column in motion.column_iter_mut() {
            for first in [0, 3] {
                let turned = pose.rotation * column.fixed_rows::<3>(first);
                column.fixed_rows_mut::<3>(first).copy_from(&turned);
            }
        }
        Some(motion)
    }

    fn rigid_pose(&self, sample: usize) -> Option<Pose> {
        // Known places give the platform's own pose; otherwise the first sample defines a frame on it.
        let known = self.target_frame() == TargetFrame::Known;
        let first: Vec<(usize, Vector3<f64>)> = self.complete(0).collect();
        let reference = |t: usize| match known {
            true => self.targets[t].platform,
            false => first.iter().find(|(k, _)| *k == t).map(|(_, p)| *p),
        };
        let (from, to): (Vec<_>, Vec<_>) =
            self.complete(sample).filter_map(|(t, seen)| Some((reference(t)?, seen))).unzip();
        fit_rigid_motion(&from, &to)
    }

    fn points(&self, sample: usize) -> Vec<PointReading> {
        let known =
            |(t, position): (usize, Vector3<f64>)| Some(PointReading { position, place: self.targets[t].platform? });
        self.complete(sample).filter_map(known).collect()
    }

    fn point(&self, sample: usize) -> Option<PointReading> {
        let known = self.target_frame() == TargetFrame::Known;
        let usable = |t: usize| if known { self.targets[t].platform } else { (t == 0).then(Vector3::zeros) };
        self.complete(sample).find_map(|(t, position)| Some(PointReading { position, place: usable(t)? }))
    }
}
