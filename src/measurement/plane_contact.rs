//! Heights of a point of the platform over a plane, zero where it touches.

use nalgebra::{DMatrix, DVector, Matrix1x3, Rotation3, Unit, Vector3};

use super::pose_measurement::point_motion;
use super::{Frames, MeasurementModel, PointReading, RowKind, Rows, Sample, TargetFrame};
use crate::mechanism::{ParameterRole, ParameterSpec};
use crate::pose::Pose;
use crate::units::Dimension;

/// A plane: the points `p` with `n · p = d`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// `n`, of length one.
    pub normal: Unit<Vector3<f64>>,
    /// `d`: distance of the plane from the origin along `n`, m.
    pub distance: f64,
}

impl Plane {
    /// The plane with a normal of any length; `None` if the normal has none or a number is not finite.
    pub fn new(normal: &Vector3<f64>, distance: f64) -> Option<Self> {
        // The largest entry first: squares of very large or very small numbers are no numbers.
        let largest = normal.amax();
        let usable = largest > 0.0 && normal.iter().chain([&distance]).all(|v| v.is_finite());
        usable.then(|| Self { normal: Unit::new_normalize(normal / largest), distance })
    }

    /// Height of a point over the plane, on the side to which the normal points, m.
    pub fn height(&self, point: &Vector3<f64>) -> f64 {
        self.normal.dot(point) - self.distance
    }

    /// The same plane in a frame in which its own frame has the pose `frame`.
    pub fn seen_from(&self, frame: &Pose) -> Self {
        let normal = frame.rotation * self.normal;
        Self { normal, distance: self.distance + normal.dot(&frame.position) }
    }
}

/// A point of the platform, and the plane over which its height is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The plane, in the tracker's frame. If it is not known, where its identification starts.
    pub plane: Plane,
    /// The tip: a point of the platform, platform frame, m.
    pub tip: Vector3<f64>,
    /// False if the plane is to be identified.
    pub known: bool,
}

impl Default for Contact {
    /// The platform origin over the known plane z = 0.
    fn default() -> Self {
        let plane = Plane { normal: Vector3::z_axis(), distance: 0.0 };
        Self { plane, tip: Vector3::zeros(), known: true }
    }
}

/// One reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactReading {
    /// Height of the tip over the plane, m; 0 where it touches, `None` if it was not measured.
    pub height: Option<f64>,
    /// Its 1σ, m.
    pub sigma: f64,
}

/// Heights of the tip over a plane: `ŷ = n · B(q c) - d` with the tip `c` and the base `B` in the tracker's frame.
///
/// One row for each sample, so that a campaign needs several times as many samples as one with full poses. A height
/// says nothing of
///
/// * a turn of all platform points about the tip (three directions), which leaves the tip where it is;
/// * shifts of all base points along the plane and their turn about its normal (three), which carry the tip along it.
///
/// A plane that is not known adds three own parameters: two tilts (rad) about fixed axes in the stated plane, and the
/// distance (m). It takes in the other three motions of all base points together: the shift along the normal and the two
/// tilts. Tolerances hold what no row sees. The heights that the calibrated model predicts are as good as ever; the pose
/// is known only as far as it moves the tip up and down.
///
/// A height determines neither a pose nor a point, so that there is no registration: plane and mechanism are stated in
/// one frame.
#[derive(Clone, Debug)]
pub struct PlaneContact {
    contact: Contact,
    readings: Vec<ContactReading>,
    /// Axes of the two tilts, of length one, at right angles to the stated normal and to each other.
    axes: [Vector3<f64>; 2],
    own: Vec<ParameterSpec>,
}

/// Rounds in which a plane is fitted to predicted poses.
const ROUNDS: usize = 20;
/// A change this small, m and rad, ends the fit.
const CLOSE: f64 = 1e-12;
/// What moves the fit by less than this part of the strongest is left alone, as with touches along a line.
const UNSEEN: f64 = 1e-6;

impl PlaneContact {
    /// Readings by sample.
    pub fn new(contact: Contact, readings: Vec<ContactReading>) -> Self {
        let normal = contact.plane.normal.into_inner();
        // The base axes x and y for a plane z = constant.
        let axis = Vector3::ith(normal.iamin(), 1.0);
        let first = (axis - normal * normal.dot(&axis)).normalize();
        let axes = [first, normal.cross(&first)];
        let spec = |name: &str, dimension: Dimension, nominal: f64| ParameterSpec {
            name: name.into(),
            dimension,
            nominal,
            tolerance: None,
            role: ParameterRole::Other,
        };
        let own = match contact.known {
            true => Vec::new(),
            false => vec![
                spec("plane_tilt1", Dimension::Angle, 0.0),
                spec("plane_tilt2", Dimension::Angle, 0.0),
                spec("plane_distance", Dimension::Length, contact.plane.distance),
            ],
        };
        Self { contact, readings, axes, own }
    }

    /// What was stated, with the identified plane put in; it counts as known then.
    pub fn located(&self, own: &[f64]) -> Contact {
        Contact { plane: self.plane(own), known: true, ..self.contact }
    }

    fn turns(&self, own: &[f64]) -> [Rotation3<f64>; 2] {
        let tilt = |k: usize| Rotation3::from_scaled_axis(self.axes[k] * own[k]);
        [tilt(0), tilt(1)]
    }

    fn plane(&self, own: &[f64]) -> Plane {
        if own.len() < 3 {
            return self.contact.plane;
        }
        let [first, second] = self.turns(own);
        Plane { normal: first * (second * self.contact.plane.normal), distance: own[2] }
    }

    /// `∂ŷ/∂` own parameters for the tip at `point`, tracker's frame.
    fn along_own(&self, own: &[f64], point: &Vector3<f64>) -> Matrix1x3<f64> {
        let [first, second] = self.turns(own);
        let once = second * self.contact.plane.normal.into_inner();
        let by_first = self.axes[0].cross(&(first * once));
        let by_second = first * self.axes[1].cross(&once);
        Matrix1x3::new(by_first.dot(point), by_second.dot(point), -1.0)
    }
}

impl MeasurementModel for PlaneContact {
    fn describe(&self) -> String {
        if self.own.is_empty() { "heights over a plane".into() } else { "heights over an unknown plane".into() }
    }

    fn samples(&self) -> usize {
        self.readings.len()
    }

    fn rows(&self, sample: usize) -> Vec<RowKind> {
        vec![RowKind::Position; usize::from(self.readings[sample].height.is_some())]
    }

    fn nuisance_parameters(&self) -> &[ParameterSpec] {
        &self.own
    }

    /// The plane from which the predicted tips have the measured heights, by Gauss–Newton from the stated one; the
    /// stated one if there is no better.
    fn start(&self, poses: &[Option<Pose>], frames: &Frames) -> Vec<f64> {
        let mut own: Vec<f64> = self.own.iter().map(|p| p.nominal).collect();
        let seen = |(reading, pose): (&ContactReading, &Option<Pose>)| {
            Some((frames.base.place(&pose.as_ref()?.place(&self.contact.tip)), reading.height?))
        };
        let tips: Vec<(Vector3<f64>, f64)> = self.readings.iter().zip(poses).filter_map(seen).collect();
        if own.is_empty() || tips.is_empty() {
            return own;
        }
        let misses = |own: &[f64]| {
            let plane = self.plane(own);
            DVector::from_iterator(tips.len(), tips.iter().map(|(tip, height)| plane.height(tip) - height))
        };
        for _ in 0..ROUNDS {
            let rows: Vec<Matrix1x3<f64>> = tips.iter().map(|(tip, _)| self.along_own(&own, tip)).collect();
            let jacobian = DMatrix::from_fn(rows.len(), 3, |r, c| rows[r][c]);
            let now = misses(&own);
            if jacobian.iter().chain(now.iter()).any(|v| !v.is_finite()) {
                break;
            }
            let svd = jacobian.svd(true, true);
            let Ok(step) = svd.solve(&now, UNSEEN * svd.singular_values.max()) else { break };
            let next: Vec<f64> = own.iter().zip(step.iter()).map(|(v, s)| v - s).collect();
            if !(misses(&next).norm() < now.norm()) {
                break;
            }
            own = next;
            if step.amax() < CLOSE {
                break;
            }
        }
        own
    }

    fn evaluate(&self, index: usize, _sample: &Sample, pose: &Pose, frames: &Frames, own: &[f64], out: &mut Rows) {
        let ContactReading { height: Some(height), .. } = self.readings[index] else { return };
        let tip = frames.base.place(&pose.place(&self.contact.tip));
        let plane = self.plane(own);
        out.residual[0] = plane.height(&tip) - height;
        let along = plane.normal.transpose() * frames.base.rotation.matrix();
        out.motion.row_mut(0).copy_from(&(along * point_motion(pose, &self.contact.tip)));
        if !self.own.is_empty() {
            out.own.row_mut(0).copy_from(&self.along_own(own, &tip));
        }
    }

    fn covariance(&self, sample: usize, _frames: &Frames) -> DMatrix<f64> {
        let k = self.rows(sample).len();
        DMatrix::from_diagonal_element(k, k, self.readings[sample].sigma.powi(2))
    }

    fn rigid_pose(&self, _sample: usize) -> Option<Pose> {
        None
    }

    fn target_frame(&self) -> TargetFrame {
        TargetFrame::Known
    }

    fn point(&self, _sample: usize) -> Option<PointReading> {
        None
    }
}
