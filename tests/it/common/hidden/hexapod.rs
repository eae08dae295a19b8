//! A six-legged machine in twelve points and six lengths, and the pose that it takes.
//!
//! The closure is `|t + R a − b| = L + δh + Δ` for each leg. What disturbs the machine may depend on the pose that the
//! disturbance leads to, so that every Newton step asks again: the root is the true state, not a first-order guess.

use nalgebra::{Matrix3, Matrix6, Rotation3, Vector3, Vector6};

/// Table 5 of Yu, Wu, Wang 2023, mm: platform x, y and base x, y of each leg; all z are 0, all lengths 800.
pub const TABLE_5: [[f64; 4]; 6] = [
    [1299.170, -348.112, 1164.388, -977.037],
    [1299.170, 348.112, 1164.388, 977.037],
    [-348.112, 1299.170, 263.945, 1496.908],
    [-951.059, 951.059, -1428.333, 519.871],
    [-951.059, -951.059, -1428.333, -519.871],
    [-348.112, -1299.170, 263.945, -1496.908],
];
/// Length of every leg at home, m.
pub const HOME_LENGTH: f64 = 0.8;

/// Joints in the platform frame, joints in the base frame, and what is added to each commanded length, m.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    pub platform: [Vector3<f64>; 6],
    pub base: [Vector3<f64>; 6],
    pub offset: [f64; 6],
}

/// Position and attitude of the platform in the base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    pub t: Vector3<f64>,
    pub r: Matrix3<f64>,
}

impl Pose {
    /// x y z α β γ with R = Rz(γ) Ry(β) Rx(α).
    pub fn of(q: [f64; 6]) -> Self {
        let about = |axis: Vector3<f64>, angle: f64| Rotation3::new(axis * angle).into_inner();
        let r = about(Vector3::z(), q[5]) * about(Vector3::y(), q[4]) * about(Vector3::x(), q[3]);
        Self { t: Vector3::new(q[0], q[1], q[2]), r }
    }

    pub fn coordinates(&self) -> [f64; 6] {
        let r = &self.r;
        let beta = (-r[(2, 0)]).atan2(r[(0, 0)].hypot(r[(1, 0)]));
        [self.t.x, self.t.y, self.t.z, r[(2, 1)].atan2(r[(2, 2)]), beta, r[(1, 0)].atan2(r[(0, 0)])]
    }

    /// The pose after a small or large rigid motion about the base origin.
    pub fn carried(&self, shift: Vector3<f64>, turn: Vector3<f64>) -> Self {
        let m = Rotation3::new(turn).into_inner();
        Self { t: m * self.t + shift, r: m * self.r }
    }
}

/// The machine at a pose: what an effect may look at.
#[derive(Clone, Debug)]
pub struct State {
    pub pose: Pose,
    /// Platform joints from the platform origin, in base axes.
    pub arms: [Vector3<f64>; 6],
    /// Unit vectors from the base joint to the platform joint.
    pub along: [Vector3<f64>; 6],
}

/// What is added to the machine: to lengths, to platform joints (platform frame), to base joints.
#[derive(Clone, Debug, Default)]
pub struct Disturbance {
    pub leg: [f64; 6],
    pub platform: [Vector3<f64>; 6],
    pub base: [Vector3<f64>; 6],
}

impl Geometry {
    pub fn nominal() -> Self {
        Self {
            platform: TABLE_5.map(|[x, y, _, _]| Vector3::new(x, y, 0.0) * 1e-3),
            base: TABLE_5.map(|[_, _, x, y]| Vector3::new(x, y, 0.0) * 1e-3),
            offset: [0.0; 6],
        }
    }

    /// The same machine with its 42 parameters changed: a, b and δh of each leg in turn.
    pub fn changed(&self, by: &[f64; 42]) -> Self {
        let mut g = self.clone();
        for (i, d) in by.chunks_exact(7).enumerate() {
            g.platform[i] += Vector3::new(d[0], d[1], d[2]);
            g.base[i] += Vector3::new(d[3], d[4], d[5]);
            g.offset[i] += d[6];
        }
        g
    }

    /// Commands that lead an undisturbed machine to a pose.
    pub fn lengths(&self, pose: &Pose) -> [f64; 6] {
        std::array::from_fn(|i| (pose.t + pose.r * self.platform[i] - self.base[i]).norm() - self.offset[i])
    }

    /// The machine at a pose, undisturbed.
    pub fn state(&self, pose: Pose) -> State {
        let arms = std::array::from_fn(|i| pose.r * self.platform[i]);
        let along = std::array::from_fn(|i| (pose.t + arms[i] - self.base[i]).normalize());
        State { pose, arms, along }
    }

    /// The pose at home lengths.
    pub fn home(&self) -> Option<Pose> {
        let start = Pose { t: Vector3::new(0.0, 0.0, 0.4757), r: Matrix3::identity() };
        self.reach(&[HOME_LENGTH; 6], start, |_| Disturbance::default())
    }

    /// The pose that commanded lengths lead to, by Newton's method from a pose nearby.
    pub fn reach(&self, commanded: &[f64; 6], near: Pose, disturb: impl Fn(&State) -> Disturbance) -> Option<Pose> {
        let mut pose = near;
        for _ in 0..60 {
            let d = disturb(&self.state(pose));
            let (mut jacobian, mut missing) = (Matrix6::zeros(), Vector6::zeros());
            for i in 0..6 {
                let arm = pose.r * (self.platform[i] + d.platform[i]);
                let leg = pose.t + arm - self.base[i] - d.base[i];
                let along = leg.normalize();
                missing[i] = commanded[i] + self.offset[i] + d.leg[i] - leg.norm();
                jacobian.fixed_view_mut::<1, 3>(i, 0).copy_from(&along.transpose());
                jacobian.fixed_view_mut::<1, 3>(i, 3).copy_from(&arm.cross(&along).transpose());
            }
            let step = jacobian.lu().solve(&missing)?;
            let turn = Rotation3::new(Vector3::new(step[3], step[4], step[5])).into_inner();
            pose = Pose { t: pose.t + Vector3::new(step[0], step[1], step[2]), r: turn * pose.r };
            // What is left after this step is smaller by the square, or by a thousand where the disturbance depends on it.
            if step.amax() < 1e-13 {
                return Some(pose);
            }
        }
        None
    }
}
