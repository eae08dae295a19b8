//! The box of poses that a mechanism is used in.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix3, Matrix6, Rotation3, Vector3};
use rand::{Rng, RngExt};

use crate::pose::{Pose, PoseConvention, rotation_vector, wrapped_angle};

/// Within this of ±90°, rad, the middle angle makes the other two turn about nearly the same axis.
const STEEP: f64 = 0.25;

/// A box about a centre, in the coordinates of a convention. Where these come near their singularity, small rotations about
/// the axes of the base take the place of the angles: a mirror on a wall has as many attitudes about home as one on a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Workspace {
    /// How the coordinates state a pose.
    pub convention: PoseConvention,
    /// Centre, m and rad.
    pub centre: [f64; 6],
    /// Half-ranges, m and rad; 0 marks a coordinate that the mechanism does not control.
    pub half: [f64; 6],
}

impl Workspace {
    /// The pose at `u`, whose six numbers run from −1 to 1.
    pub fn pose(&self, u: &[f64; 6]) -> Pose {
        if self.is_steep() {
            let [x, y, z, a, b, c]: [f64; 6] = std::array::from_fn(|k| u[k] * self.half[k]);
            let centre = self.convention.pose(&self.centre);
            let pivot = centre.place(&self.convention.pivot) + Vector3::new(x, y, z);
            let rotation = Rotation3::from_scaled_axis(Vector3::new(a, b, c)) * centre.rotation;
            return Pose { position: pivot - rotation * self.convention.pivot, rotation };
        }
        let mut q = self.centre;
        for k in 0..6 {
            q[k] += u[k] * self.half[k];
        }
        self.convention.pose(&q)
    }

    /// How far a pose is from the centre in each coordinate, m and rad.
    pub fn offsets(&self, pose: &Pose) -> [f64; 6] {
        let q = self.convention.coordinates(pose);
        let mut offsets = std::array::from_fn(|k| q[k] - self.centre[k]);
        if self.is_steep() {
            let centre = self.convention.pose(&self.centre);
            let turn = rotation_vector(&(pose.rotation * centre.rotation.inverse()));
            offsets[3..].copy_from_slice(turn.as_slice());
        }
        offsets[3..].iter_mut().for_each(|angle| *angle = wrapped_angle(*angle));
        offsets
    }

    /// How far a pose is beyond the half-range of each coordinate, m and rad; 0 inside, and where the half-range is 0.
    pub fn excess(&self, pose: &Pose) -> [f64; 6] {
        let offsets = self.offsets(pose);
        std::array::from_fn(|k| if self.half[k] > 0.0 { (offsets[k].abs() - self.half[k]).max(0.0) } else { 0.0 })
    }

    /// The rates (6 × 6) of the coordinates of the box along a small motion: those of the convention, or small rotations.
    pub fn rates(&self, pose: &Pose) -> Matrix6<f64> {
        if !self.is_steep() {
            return self.convention.rates(pose);
        }
        let mut rates = Matrix6::identity();
        let arm: Matrix3<f64> = (pose.rotation * self.convention.pivot).cross_matrix();
        rates.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-arm));
        rates
    }

    /// True if the angles of the box come near their singularity.
    fn is_steep(&self) -> bool {
        self.half[3..].iter().any(|half| *half > 0.0) && self.centre[4].abs() + self.half[4] > FRAC_PI_2 - STEEP
    }

    /// A pose drawn uniformly.
    pub fn random<R: Rng + ?Sized>(&self, rng: &mut R) -> Pose {
        let mut u = [0.0; 6];
        for v in &mut u {
            *v = rng.random_range(-1.0..=1.0);
        }
        self.pose(&u)
    }

    /// The corners of the box: 64, or fewer where half-ranges are 0.
    pub fn corners(&self) -> Vec<Pose> {
        let free: Vec<usize> = (0..6).filter(|&k| self.half[k] > 0.0).collect();
        let corner = |bits: usize| {
            let mut u = [0.0; 6];
            for (bit, &k) in free.iter().enumerate() {
                u[k] = if bits >> bit & 1 == 1 { 1.0 } else { -1.0 };
            }
            self.pose(&u)
        };
        (0..1_usize << free.len()).map(corner).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::RotationOrder;

    fn about(beta: f64) -> Workspace {
        let convention = PoseConvention { order: RotationOrder::Xyz, pivot: Vector3::new(0.1, -0.2, 0.3) };
        Workspace { convention, centre: [0.2, 0.1, 0.4, 0.3, beta, -0.7], half: [0.03, 0.02, 0.04, 0.1, 0.08, 0.12] }
    }

    #[test]
    fn a_box_has_all_its_coordinates_at_any_attitude() {
        for beta in [0.0, 1.2, 1.4, FRAC_PI_2, -FRAC_PI_2] {
            let workspace = about(beta);
            let u = [0.5, -1.0, 0.25, 1.0, -0.5, -1.0];
            let pose = workspace.pose(&u);
            let offsets = workspace.offsets(&pose);
            for k in 0..6 {
                assert!((offsets[k] - u[k] * workspace.half[k]).abs() < 1e-9, "{beta}: {k}: {offsets:?}");
            }
            assert!(workspace.excess(&pose).iter().all(|e| *e < 1e-9), "{beta}");
            assert!((workspace.excess(&workspace.pose(&[2.0, 0.0, 0.0, 0.0, 0.0, 0.0]))[0] - 0.03).abs() < 1e-12);
        }
    }

    #[test]
    fn rates_agree_with_differences_of_the_offsets() {
        let step = 1e-6;
        for beta in [0.3, FRAC_PI_2] {
            let workspace = about(beta);
            // At the centre of the box small rotations and the rotation vector have the same rates.
            let centre = workspace.pose(&[0.0; 6]);
            let rates = workspace.rates(&centre);
            for k in 0..6 {
                let mut d = nalgebra::Vector6::zeros();
                d[k] = step;
                let [plus, minus] = [d, -d].map(|d| workspace.offsets(&centre.moved(&d)));
                for i in 0..6 {
                    let numeric = (plus[i] - minus[i]) / (2.0 * step);
                    assert!((rates[(i, k)] - numeric).abs() < 1e-7, "{beta}: ({i}, {k})");
                }
            }
        }
    }
}
