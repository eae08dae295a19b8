//! Poses of the platform, and the conventions for writing them.
//!
//! A [`Pose`] is a rigid motion: the position `t` of the platform's origin in the base frame and the
//! rotation `R` from the platform frame to the base frame. A platform point `a` is at `t + R a`.
//!
//! **Coordinates.** The paper (eq. 2) writes a pose as `q = (x, y, z, α, β, γ)` with
//! `R = R_z(γ) R_y(β) R_x(α)`. Instruments write it in other ways: with `R = R_x R_y R_z`, or with the
//! position of another point of the platform (the *pivot*). A [`PoseConvention`] is such a way of writing;
//! it is used at the boundaries, in files and measurements.
//!
//! **Small motions.** Inside the library derivatives are taken along a *small motion*
//! `δ = (δt, δω)`: the origin moves by `δt` and the platform rotates by the rotation vector `δω`, both in
//! base axes, `t ← t + δt`, `R ← exp([δω]×) R`. The six numbers of `q` have a singularity at
//! `β = ±90°`; a small motion has none, so that a platform seen from a tracker that lies on its side is as
//! good as any other. [`PoseConvention::rates`] converts: `dq/dt = C(q) δ`.

mod convention;
mod rigid_fit;

pub use convention::{PoseConvention, RotationOrder};
pub use rigid_fit::{fit_rigid_motion, kabsch};

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3, Vector6};

/// Position and orientation of the platform in the base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// `t`: the platform's origin in the base frame, m.
    pub position: Vector3<f64>,
    /// `R`: from the platform frame to the base frame.
    pub rotation: Rotation3<f64>,
}

impl Pose {
    /// The pose whose frames coincide.
    pub fn identity() -> Self {
        Self { position: Vector3::zeros(), rotation: Rotation3::identity() }
    }

    /// The pose with coordinates `q = (x, y, z, α, β, γ)` of eq. (2), in m and rad.
    pub fn from_coordinates(q: &[f64; 6]) -> Self {
        PoseConvention::default().pose(q)
    }

    /// The coordinates `q = (x, y, z, α, β, γ)` of eq. (2), in m and rad, with `|β| ≤ π/2`.
    pub fn coordinates(&self) -> [f64; 6] {
        PoseConvention::default().coordinates(self)
    }

    /// The pose after the small motion `δ = (δt, δω)` in base axes.
    pub fn moved(&self, motion: &Vector6<f64>) -> Self {
        let turn = Rotation3::from_scaled_axis(Vector3::new(motion[3], motion[4], motion[5]));
        Self { position: self.position + Vector3::new(motion[0], motion[1], motion[2]), rotation: turn * self.rotation }
    }

    /// The motion `δ` with `self.moved(δ) == other`; its rotation vector is at most π long.
    pub fn motion_to(&self, other: &Self) -> Vector6<f64> {
        let t = other.position - self.position;
        let w = rotation_vector(&(other.rotation * self.rotation.inverse()));
        Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z)
    }

    /// Where the platform point `a` stands in the base frame.
    pub fn place(&self, a: &Vector3<f64>) -> Vector3<f64> {
        self.position + self.rotation * a
    }

    /// `self` followed by `inner`: the pose of a frame whose pose on the platform is `inner`.
    pub fn compose(&self, inner: &Self) -> Self {
        Self { position: self.place(&inner.position), rotation: self.rotation * inner.rotation }
    }

    /// The inverse motion.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.inverse();
        Self { position: -(rotation * self.position), rotation }
    }

    /// True if every number of the pose is finite.
    pub fn is_finite(&self) -> bool {
        self.position.iter().chain(self.rotation.matrix().iter()).all(|v| v.is_finite())
    }

    /// This motion as nalgebra's isometry.
    pub fn to_isometry(&self) -> Isometry3<f64> {
        Isometry3::from_parts(Translation3::from(self.position), UnitQuaternion::from_rotation_matrix(&self.rotation))
    }
}

impl Default for Pose {
    fn default() -> Self {
        Self::identity()
    }
}

/// The angle in (−π, π] that differs from `angle`, rad, by whole turns.
pub fn wrapped_angle(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    if angle.abs() <= PI { angle } else { angle - TAU * (angle / TAU).round() }
}

/// The rotation vector of `rotation`, at most π long, accurate to rounding for the smallest turns.
///
/// nalgebra's own takes the arc cosine of the trace, which loses half of the digits there.
pub fn rotation_vector(rotation: &Rotation3<f64>) -> Vector3<f64> {
    let r = rotation.matrix();
    let v = 0.5 * Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]);
    let (sine, cosine) = (v.norm(), 0.5 * (r.trace() - 1.0));
    if cosine <= 0.0 {
        return UnitQuaternion::from_rotation_matrix(rotation).scaled_axis();
    }
    // Also for what is not a number, of which the quaternion would make no turn at all.
    if sine == 0.0 { v } else { v * (sine.atan2(cosine) / sine) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    #[test]
    fn rotation_is_the_one_of_equation_2() {
        let (a, b, g) = (0.3_f64, -0.4_f64, 0.9_f64);
        let r = Pose::from_coordinates(&[0.0, 0.0, 0.0, a, b, g]).rotation;
        let printed = Matrix3::new(
            g.cos() * b.cos(),
            g.cos() * b.sin() * a.sin() - g.sin() * a.cos(),
            g.cos() * b.sin() * a.cos() + g.sin() * a.sin(),
            g.sin() * b.cos(),
            g.sin() * b.sin() * a.sin() + g.cos() * a.cos(),
            g.sin() * b.sin() * a.cos() - g.cos() * a.sin(),
            -b.sin(),
            b.cos() * a.sin(),
            b.cos() * a.cos(),
        );
        assert!((r.matrix() - printed).norm() < 1e-15);
    }

    #[test]
    fn what_is_not_a_number_is_no_turn_of_zero() {
        let nan = Rotation3::from_matrix_unchecked(Matrix3::repeat(f64::NAN));
        assert!(rotation_vector(&nan).iter().all(|v| v.is_nan()));
    }

    #[test]
    fn moving_and_measuring_the_motion_are_inverse() {
        let p = Pose::from_coordinates(&[0.1, 0.2, 0.3, 1.0, -0.5, 2.0]);
        let m = Vector6::new(0.4, -0.1, 0.2, 0.3, -0.7, 0.2);
        assert!((p.motion_to(&p.moved(&m)) - m).norm() < 1e-14);
        let back = p.compose(&p.inverse());
        assert!(back.position.norm() < 1e-15 && rotation_vector(&back.rotation).norm() < 1e-15);
    }
}
