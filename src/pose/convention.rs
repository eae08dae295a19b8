//! Ways to write a pose as six numbers.

use nalgebra::{Matrix3, Matrix6, Rotation3, Vector3};
use serde::{Deserialize, Serialize};

use super::Pose;

/// The order in which the three elementary rotations are multiplied.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RotationOrder {
    /// `R = R_z(γ) R_y(β) R_x(α)`, eq. (2) of the paper.
    #[default]
    Zyx,
    /// `R = R_x(α) R_y(β) R_z(γ)`, as the hexapods of the Rubin Observatory have it.
    Xyz,
}

/// How six numbers `(x, y, z, α, β, γ)` state a pose: the order of the rotations, and the platform point
/// whose position they give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseConvention {
    /// Order of the elementary rotations.
    pub order: RotationOrder,
    /// The platform point whose position the pose states, platform frame, m.
    pub pivot: Vector3<f64>,
}

impl Default for PoseConvention {
    fn default() -> Self {
        Self { order: RotationOrder::Zyx, pivot: Vector3::zeros() }
    }
}

impl PoseConvention {
    /// The rotation with the angles `(α, β, γ)`, rad.
    pub fn rotation(&self, angles: &Vector3<f64>) -> Rotation3<f64> {
        let (x, y, z) = (
            Rotation3::from_axis_angle(&Vector3::x_axis(), angles.x),
            Rotation3::from_axis_angle(&Vector3::y_axis(), angles.y),
            Rotation3::from_axis_angle(&Vector3::z_axis(), angles.z),
        );
        match self.order {
            RotationOrder::Zyx => z * y * x,
            RotationOrder::Xyz => x * y * z,
        }
    }

    /// The angles `(α, β, γ)` of a rotation, rad, with `|β| ≤ π/2`.
    pub fn angles(&self, rotation: &Rotation3<f64>) -> Vector3<f64> {
        let r = rotation.matrix();
        // atan2 with the length of the other row entries keeps β accurate near ±90°, where asin is not.
        match self.order {
            RotationOrder::Zyx => Vector3::new(
                r[(2, 1)].atan2(r[(2, 2)]),
                (-r[(2, 0)]).atan2(r[(2, 1)].hypot(r[(2, 2)])),
                r[(1, 0)].atan2(r[(0, 0)]),
            ),
            RotationOrder::Xyz => Vector3::new(
                (-r[(1, 2)]).atan2(r[(2, 2)]),
                r[(0, 2)].atan2(r[(1, 2)].hypot(r[(2, 2)])),
                (-r[(0, 1)]).atan2(r[(0, 0)]),
            ),
        }
    }

    /// The pose that six numbers state, in m and rad.
    pub fn pose(&self, q: &[f64; 6]) -> Pose {
        let rotation = self.rotation(&Vector3::new(q[3], q[4], q[5]));
        Pose { position: Vector3::new(q[0], q[1], q[2]) - rotation * self.pivot, rotation }
    }

    /// The six numbers of a pose, in m and rad.
    pub fn coordinates(&self, pose: &Pose) -> [f64; 6] {
        let p = pose.place(&self.pivot);
        let a = self.angles(&pose.rotation);
        [p.x, p.y, p.z, a.x, a.y, a.z]
    }

    /// The axes about which `α`, `β`, `γ` turn, in base axes: `ω = E (dα, dβ, dγ)/dt`.
    ///
    /// For `Zyx` its columns are `R_z R_y e_x`, `R_z e_y`, `e_z`, the matrix `E` of the paper's `J₁`.
    pub fn angle_axes(&self, angles: &Vector3<f64>) -> Matrix3<f64> {
        let turn = |axis: &nalgebra::UnitVector3<f64>, angle| Rotation3::from_axis_angle(axis, angle);
        let (x, y, z) = (Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis());
        match self.order {
            RotationOrder::Zyx => {
                let rz = turn(&z, angles.z);
                Matrix3::from_columns(&[rz * turn(&y, angles.y) * x.into_inner(), rz * y.into_inner(), z.into_inner()])
            }
            RotationOrder::Xyz => {
                let rx = turn(&x, angles.x);
                Matrix3::from_columns(&[x.into_inner(), rx * y.into_inner(), rx * turn(&y, angles.y) * z.into_inner()])
            }
        }
    }

    /// The rates `C` (6 × 6) of the six numbers along a small motion, `dq/dt = C (δt, δω)`.
    ///
    /// Within about 1e-8 rad of `β = ±90°` the angles have no rates; the entries are then huge or not
    /// finite, and callers that may get there work with rotation vectors instead.
    pub fn rates(&self, pose: &Pose) -> Matrix6<f64> {
        let mut c = Matrix6::identity();
        if self.pivot != Vector3::zeros() {
            let arm = (pose.rotation * self.pivot).cross_matrix();
            c.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-arm));
        }
        let e = self.angle_axes(&self.angles(&pose.rotation));
        let inverse = e.try_inverse().unwrap_or_else(|| Matrix3::repeat(f64::NAN));
        c.fixed_view_mut::<3, 3>(3, 3).copy_from(&inverse);
        c
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector6;

    fn conventions() -> [PoseConvention; 3] {
        let pivot = Vector3::new(0.1, -0.2, -2.7);
        [
            PoseConvention::default(),
            PoseConvention { order: RotationOrder::Xyz, pivot: Vector3::zeros() },
            PoseConvention { order: RotationOrder::Xyz, pivot },
        ]
    }

    #[test]
    fn coordinates_and_pose_are_inverse() {
        for convention in conventions() {
            for q in [[0.1, 0.2, -0.3, 0.4, -1.2, 2.9], [1.0, 0.0, 5.0, -3.0, 0.0, 0.0]] {
                let back = convention.coordinates(&convention.pose(&q));
                for (a, b) in q.iter().zip(back) {
                    assert!((a - b).abs() < 1e-14, "{convention:?}: {q:?} -> {back:?}");
                }
            }
        }
    }

    #[test]
    fn rates_agree_with_central_differences() {
        let step = 1e-6;
        for convention in conventions() {
            let pose = Pose::from_coordinates(&[0.1, -0.2, 0.4, 0.3, -0.8, 1.1]);
            let rates = convention.rates(&pose);
            for k in 0..6 {
                let mut d = Vector6::zeros();
                d[k] = step;
                let (plus, minus) = (convention.coordinates(&pose.moved(&d)), convention.coordinates(&pose.moved(&-d)));
                for i in 0..6 {
                    let numeric = (plus[i] - minus[i]) / (2.0 * step);
                    assert!((rates[(i, k)] - numeric).abs() < 1e-8, "{convention:?} ({i}, {k})");
                }
            }
        }
    }
}
