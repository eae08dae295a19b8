//! The box of poses that a mechanism is used in.

use rand::{Rng, RngExt};

use crate::pose::{Pose, PoseConvention};

/// A box about a centre, in the coordinates of a convention.
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
        let mut q = self.centre;
        for k in 0..6 {
            q[k] += u[k] * self.half[k];
        }
        self.convention.pose(&q)
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
