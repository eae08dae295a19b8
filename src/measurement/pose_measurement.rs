//! Measured poses, whole or in part.

use nalgebra::{DMatrix, Matrix3, Matrix3x6, Rotation3, Vector3};

use super::{Frames, MeasurementModel, PointReading, RowKind, Rows, Sample, numbered};
use crate::pose::{Pose, PoseConvention, rotation_vector, wrapped_angle};

/// Beyond this |β|, rad, differences of the angles no longer tell the size of a turn: one angle counts up to 1/cos β
/// times as much.
const STEEP: f64 = std::f64::consts::FRAC_PI_6;

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
/// tracker that lies on its side meets no singularity, and equal σ of the three angles stay what they are. Should
/// the platform itself be tilted by more than 30°, attitudes are compared as rotation vectors.
/// If an angle is missing, the others are compared as they stand in the file.
///
/// The same attitude can be written as many triples of angles; all give the same rows.
#[derive(Clone, Debug)]
pub struct PoseMeasurement {
    convention: PoseConvention,
    readings: Vec<PoseReading>,
    /// Of each reading with all three angles.
    attitudes: Vec<Option<Attitude>>,
}

/// A measured attitude in the tracker's frame.
#[derive(Clone, Copy, Debug)]
struct Attitude {
    rotation: Rotation3<f64>,
    /// Its angles with `|β| ≤ π/2`, whichever triple the file has.
    angles: Vector3<f64>,
}

impl PoseMeasurement {
    /// Readings in the coordinates of a convention.
    pub fn new(convention: PoseConvention, readings: Vec<PoseReading>) -> Self {
        let attitude = |reading: &PoseReading| {
            let rotation = convention.rotation(&reading_angles(reading));
            let angles = convention.angles(&rotation);
            reading.measured[3..].iter().all(|m| *m).then_some(Attitude { rotation, angles })
        };
        let attitudes = readings.iter().map(attitude).collect();
        Self { convention, readings, attitudes }
    }

    /// Full poses with the same noise in each row.
    pub fn full(convention: PoseConvention, poses: &[Pose], position_sigma: f64, rotation_sigma: f64) -> Self {
        let (p, r) = (position_sigma, rotation_sigma);
        let reading = |pose: &Pose| PoseReading {
            values: convention.coordinates(pose),
            measured: [true; 6],
            sigma: [p, p, p, r, r, r],
        };
        Self::new(convention, poses.iter().map(reading).collect())
    }

    /// The measured attitude as it is in the base frame.
    fn in_base(&self, full: &Rotation3<f64>, frames: &Frames) -> Rotation3<f64> {
        frames.base.rotation.inverse() * full * frames.target.rotation.inverse()
    }

    /// Differences of the three angles in the base frame and their rates, or of the attitudes as a rotation vector
    /// where the angles are near their singularity.
    fn attitude_rows(&self, attitude: &Attitude, pose: &Pose, frames: &Frames) -> (Vector3<f64>, Matrix3<f64>) {
        let seen = self.in_base(&attitude.rotation, frames);
        let measured = if frames.is_identity() { attitude.angles } else { self.convention.angles(&seen) };
        if measured.y.abs() > STEEP {
            let turn = rotation_vector(&(pose.rotation * seen.inverse()));
            return (turn, rotation_vector_rates(&turn));
        }
        let angles = self.convention.angles(&pose.rotation);
        (angles - measured, inverse_or_nan(&self.convention.angle_axes(&angles)))
    }
}

fn reading_angles(reading: &PoseReading) -> Vector3<f64> {
    Vector3::from_column_slice(&reading.values[3..])
}

/// `∂φ/∂δω` for a rotation vector `φ` whose rotation is followed by the small turn `δω`:
/// `I - [φ]×/2 + (1/θ² - (1 + cos θ)/(2 θ sin θ)) [φ]×²` with `θ = |φ|`.
fn rotation_vector_rates(turn: &Vector3<f64>) -> Matrix3<f64> {
    let cross = turn.cross_matrix();
    let angle = turn.norm();
    let factor = match angle < 1e-2 {
        true => 1.0 / 12.0 + angle * angle / 720.0,
        false => 1.0 / (angle * angle) - (1.0 + angle.cos()) / (2.0 * angle * angle.sin()),
    };
    Matrix3::identity() - 0.5 * cross + factor * cross * cross
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

    fn row_of_each(&self, sample: usize) -> Vec<Option<usize>> {
        numbered(self.readings[sample].measured)
    }

    fn evaluate(&self, index: usize, _sample: &Sample, pose: &Pose, frames: &Frames, _own: &[f64], out: &mut Rows) {
        let reading = &self.readings[index];
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
        let (difference, rates) = match &self.attitudes[index] {
            Some(attitude) => self.attitude_rows(attitude, pose, frames),
            None => {
                let seen = frames.base.rotation * pose.rotation * frames.target.rotation;
                let angles = self.convention.angles(&seen);
                let rates = inverse_or_nan(&self.convention.angle_axes(&angles)) * turn;
                (angles - reading_angles(reading), rates)
            }
        };
        for k in (0..3).filter(|&k| reading.measured[k + 3]) {
            out.residual[row] = wrapped_angle(difference[k]);
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
        if let (Some(Attitude { rotation: full, angles: stated }), true) = (&self.attitudes[sample], unequal) {
            // Unequal σ of the three angles are carried to the rows that `attitude_rows` makes of them.
            let seen = self.in_base(full, frames);
            let angles = self.convention.angles(&seen);
            let rates = if angles.y.abs() > STEEP {
                Matrix3::identity()
            } else {
                inverse_or_nan(&self.convention.angle_axes(&angles))
            };
            let to_base = rates * frames.base.rotation.inverse().matrix() * self.convention.angle_axes(stated);
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

    fn coordinates(&self, sample: usize) -> Option<[f64; 6]> {
        let reading = &self.readings[sample];
        reading.measured.iter().all(|m| *m).then_some(reading.values)
    }

    fn point(&self, sample: usize) -> Option<PointReading> {
        let reading = &self.readings[sample];
        let position = Vector3::from_column_slice(&reading.values[..3]);
        let seen = PointReading { position, place: self.convention.pivot };
        reading.measured[..3].iter().all(|m| *m).then_some(seen)
    }
}

/// The part of a motion block that a position sees at a platform point: `[I, -[R c]]`.
pub(super) fn point_motion(pose: &Pose, c: &Vector3<f64>) -> Matrix3x6<f64> {
    let mut m = Matrix3x6::zeros();
    m.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::identity());
    m.fixed_view_mut::<3, 3>(0, 3).copy_from(&-(pose.rotation * c).cross_matrix());
    m
}
