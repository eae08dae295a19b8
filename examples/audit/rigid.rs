//! Rigid motions of the generator: own rotation matrices, own angles.

use nalgebra::{Matrix3, Rotation3, Vector3};
use paracal::pose::{Pose, PoseConvention, RotationOrder};

use crate::dice::Dice;

/// A position, m, and a rotation matrix.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rigid {
    pub(crate) at: Vector3<f64>,
    pub(crate) turn: Matrix3<f64>,
}

impl Rigid {
    pub(crate) fn identity() -> Self {
        Self { at: Vector3::zeros(), turn: Matrix3::identity() }
    }

    pub(crate) fn shifted(at: Vector3<f64>) -> Self {
        Self { at, ..Self::identity() }
    }

    pub(crate) fn place(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.at + self.turn * point
    }

    /// `self` followed by `inner`.
    pub(crate) fn then(&self, inner: &Self) -> Self {
        Self { at: self.place(&inner.at), turn: self.turn * inner.turn }
    }

    /// Moved by a shift and turned by a rotation vector about its own place.
    pub(crate) fn moved(&self, shift: &Vector3<f64>, turn: &Vector3<f64>) -> Self {
        Self { at: self.at + shift, turn: turn_by(turn) * self.turn }
    }

    /// The same in the library's type.
    pub(crate) fn pose(&self) -> Pose {
        Pose { position: self.at, rotation: Rotation3::from_matrix_unchecked(self.turn) }
    }

    pub(crate) fn of(pose: &Pose) -> Self {
        Self { at: pose.position, turn: *pose.rotation.matrix() }
    }

    /// The six numbers by which a file states it.
    pub(crate) fn written(&self, convention: &PoseConvention) -> [f64; 6] {
        let p = self.place(&convention.pivot);
        let [a, b, c] = angles(convention.order, &self.turn);
        [p.x, p.y, p.z, a, b, c]
    }

    /// The motion that six numbers state.
    pub(crate) fn read(convention: &PoseConvention, q: &[f64; 6]) -> Self {
        let turn = turned(convention.order, [q[3], q[4], q[5]]);
        Self { at: Vector3::new(q[0], q[1], q[2]) - turn * convention.pivot, turn }
    }
}

fn about(axis: usize, angle: f64) -> Matrix3<f64> {
    let (s, c) = angle.sin_cos();
    match axis {
        0 => Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c),
        1 => Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c),
        _ => Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0),
    }
}

/// The product of the elementary rotations by three angles.
fn turned(order: RotationOrder, [a, b, c]: [f64; 3]) -> Matrix3<f64> {
    match order {
        RotationOrder::Zyx => about(2, c) * about(1, b) * about(0, a),
        RotationOrder::Xyz => about(0, a) * about(1, b) * about(2, c),
    }
}

/// The three angles of a rotation, the middle one within a right angle.
fn angles(order: RotationOrder, m: &Matrix3<f64>) -> [f64; 3] {
    match order {
        RotationOrder::Zyx => {
            let middle = (-m[(2, 0)]).atan2((m[(0, 0)].powi(2) + m[(1, 0)].powi(2)).sqrt());
            [m[(2, 1)].atan2(m[(2, 2)]), middle, m[(1, 0)].atan2(m[(0, 0)])]
        }
        RotationOrder::Xyz => {
            let middle = m[(0, 2)].atan2((m[(0, 0)].powi(2) + m[(0, 1)].powi(2)).sqrt());
            [(-m[(1, 2)]).atan2(m[(2, 2)]), middle, (-m[(0, 1)]).atan2(m[(0, 0)])]
        }
    }
}

/// The turn by a rotation vector, by the half-angle quaternion.
pub(crate) fn turn_by(vector: &Vector3<f64>) -> Matrix3<f64> {
    let half = 0.5 * vector.norm();
    let sinc = if half < 1e-4 { 0.5 * (1.0 - half * half / 6.0) } else { half.sin() / (2.0 * half) };
    of_quaternion(half.cos(), vector * sinc)
}

fn of_quaternion(w: f64, v: Vector3<f64>) -> Matrix3<f64> {
    let (x, y, z) = (v.x, v.y, v.z);
    Matrix3::new(
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )
}

/// Any rotation, all alike.
pub(crate) fn any_turn(dice: &mut Dice) -> Matrix3<f64> {
    let mut q = [0.0; 4];
    q.iter_mut().for_each(|v| *v = dice.normal());
    let norm = q.iter().map(|v| v * v).sum::<f64>().sqrt();
    of_quaternion(q[0] / norm, Vector3::new(q[1], q[2], q[3]) / norm)
}

/// Angle between two attitudes, rad, exact for the smallest: the chord of two rotations is `2√2 sin(θ/2)`.
pub(crate) fn angle_between(a: &Matrix3<f64>, b: &Matrix3<f64>) -> f64 {
    2.0 * ((a - b).norm() / 8_f64.sqrt()).min(1.0).asin()
}
