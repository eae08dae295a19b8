//! Measured poses, whole or in part.

use nalgebra::{DMatrix, Matrix3, Matrix3x6, Rotation3, Vector3};

use super::{Frames, MeasurementModel, RowKind, Rows};
use crate::pose::{Pose, PoseConvention};

/// One measured pose in the coordinates of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseReading {
    /// Coordinates, m and rad; those that were not measured are ignored.
    pub values: [f64; 6],
    /// Which of them were measured.
    pub measured: [bool; 6],
    /// 1σ of each coordinate, m and rad.
    pub sigma: [f64; 6],
}

/// Poses measured as six coordinates, of which some may be missing.
///
/// Position rows are compared in the tracker's frame. If all three angles were measured, the attitude is
/// compared in the base frame, as angles of the file's convention about the platform's own attitude: a
/// tracker that lies on its side meets no singularity, and equal σ of the three angles stay what they are.
/// If an angle is missing, the others are compared as they stand in the file.
#[derive(Clone, Debug)]
pub struct PoseMeasurement {
    convention: PoseConvention,
    readings: Vec<PoseReading>,
}

impl PoseMeasurement {
    /// Readings in the coordinates of a convention.
    pub fn new(convention: PoseConvention, readings: Vec<PoseReading>) -> Self {
        Self { convention, readings }
    }

    /// Full poses with the same noise in each row.
    pub fn full(convention: PoseConvention, poses: &[Pose], position_sigma: f64, rotation_sigma: f64) -> Self {
        let (p, r) = (position_sigma, rotation_sigma);
        let reading = |pose: &Pose| PoseReading {
            values: convention.coordinates(pose),
            measured: [true; 6],
            sigma: [p, p, p, r, r, r],
        };
        Self { convention, readings: poses.iter().map(reading).collect() }
    }

    /// The readings.
    pub fn readings(&self) -> &[PoseReading] {
        &self.readings
    }

    fn rotation(&self, reading: &PoseReading) -> Option<Rotation3<f64>> {
        let [.., a, b, c] = reading.values;
        reading.measured[3..].iter().all(|m| *m).then(|| self.convention.rotation(&Vector3::new(a, b, c)))
    }
}

/// The angle in (−π, π] that differs from `angle` by whole turns.
fn wrapped(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    if angle.abs() <= PI { angle } else { angle - TAU * (angle / TAU).round() }
}

fn inverse_or_nan(m: &Matrix3<f64>) -> Matrix3<f64> {
    m.try_inverse().unwrap_or_else(|| Matrix3::repeat(f64::NAN))
}

impl MeasurementModel for PoseMeasurement {
    fn describe(&self) -> String {
        const NAMES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];
        let always = |k: usize| self.readings.iter().all(|r| r.measured[k]);
        if (0..6).all(always) {
            return "full poses".into();
        }
        let names: Vec<&str> =
            (0..6).filter(|&k| self.readings.iter().any(|r| r.measured[k])).map(|k| NAMES[k]).collect();
        format!("parts of poses ({})", names.join(", "))
    }

    fn samples(&self) -> usize {
        self.readings.len()
    }

    fn rows(&self, sample: usize) -> Vec<RowKind> {
        let kind = |k: usize| if k < 3 { RowKind::Position } else { RowKind::Rotation };
        (0..6).filter(|&k| self.readings[sample].measured[k]).map(kind).collect()
    }

    fn evaluate(&self, sample: usize, pose: &Pose, frames: &Frames, _own: &[f64], out: &mut Rows) {
        let reading = &self.readings[sample];
        let arm = pose.rotation * frames.target.place(&self.convention.pivot);
        let point = frames.base.place(&(pose.position + arm));
        // d(point) = R_B (δt + δω × arm)
        let turn = frames.base.rotation.matrix();
        let lever = -(turn * arm.cross_matrix());
        let mut row = 0;
        for k in (0..3).filter(|&k| reading.measured[k]) {
            out.residual[row] = point[k] - reading.values[k];
            for c in 0..3 {
                out.motion[(row, c)] = turn[(k, c)];
                out.motion[(row, c + 3)] = lever[(k, c)];
            }
            row += 1;
        }
        if !reading.measured[3..].iter().any(|m| *m) {
            return;
        }
        let (angles, measured, rates) = match self.rotation(reading) {
            Some(full) => {
                let angles = self.convention.angles(&pose.rotation);
                let seen = if frames.is_identity() {
                    Vector3::new(reading.values[3], reading.values[4], reading.values[5])
                } else {
                    let seen = frames.base.rotation.inverse() * full * frames.target.rotation.inverse();
                    self.convention.angles(&seen)
                };
                (angles, seen, inverse_or_nan(&self.convention.angle_axes(&angles)))
            }
            None => {
                let seen = frames.base.rotation * pose.rotation * frames.target.rotation;
                let angles = self.convention.angles(&seen);
                let measured = Vector3::new(reading.values[3], reading.values[4], reading.values[5]);
                (angles, measured, inverse_or_nan(&self.convention.angle_axes(&angles)) * turn)
            }
        };
        for k in (0..3).filter(|&k| reading.measured[k + 3]) {
            out.residual[row] = wrapped(angles[k] - measured[k]);
            for c in 0..3 {
                out.motion[(row, c)] = 0.0;
                out.motion[(row, c + 3)] = rates[(k, c)];
            }
            row += 1;
        }
    }

    fn covariance(&self, sample: usize, frames: &Frames) -> DMatrix<f64> {
        let reading = &self.readings[sample];
        let measured: Vec<usize> = (0..6).filter(|&k| reading.measured[k]).collect();
        let mut covariance = DMatrix::zeros(measured.len(), measured.len());
        for (row, &k) in measured.iter().enumerate() {
            covariance[(row, row)] = reading.sigma[k].powi(2);
        }
        let [.., a, b, c] = reading.sigma;
        let unequal = a != b || b != c;
        if let (Some(full), true, false) = (self.rotation(reading), unequal, frames.is_identity()) {
            // Unequal σ of the three angles are carried from the tracker's angles to those of the base frame.
            let seen = frames.base.rotation.inverse() * full * frames.target.rotation.inverse();
            let to_base = inverse_or_nan(&self.convention.angle_axes(&self.convention.angles(&seen)))
                * frames.base.rotation.inverse().matrix()
                * self.convention.angle_axes(&self.convention.angles(&full));
            let carried = to_base * Matrix3::from_diagonal(&Vector3::new(a * a, b * b, c * c)) * to_base.transpose();
            let first = measured.len() - 3;
            covariance.view_mut((first, first), (3, 3)).copy_from(&carried);
        }
        covariance
    }

    fn rigid_pose(&self, sample: usize) -> Option<Pose> {
        let reading = &self.readings[sample];
        reading.measured.iter().all(|m| *m).then(|| self.convention.pose(&reading.values))
    }

    fn point(&self, sample: usize) -> Option<Vector3<f64>> {
        let reading = &self.readings[sample];
        let [x, y, z, ..] = reading.values;
        reading.measured[..3].iter().all(|m| *m).then(|| Vector3::new(x, y, z))
    }
}

/// The part of a motion block that a position sees at a platform point: `[I, -[R c]]`.
pub(super) fn point_motion(pose: &Pose, c: &Vector3<f64>) -> Matrix3x6<f64> {
    let mut m = Matrix3x6::zeros();
    m.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::identity());
    m.fixed_view_mut::<3, 3>(0, 3).copy_from(&-(pose.rotation * c).cross_matrix());
    m
}
