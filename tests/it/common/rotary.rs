//! A mechanism with joints and parameters that are angles: a planar 3-RRR with cranks.

use paracal::conditions::Conditions;
use paracal::mechanism::{
    Axis, GeometryError, JointSpec, KinematicsError, Linearization, Mechanism, MechanismCore, ParameterRole,
    ParameterSpec, Workspace, forward_by_closure,
};
use paracal::nalgebra::Vector3;
use paracal::pose::{Pose, PoseConvention};
use paracal::units::Dimension;

const PER_LEG: usize = 7;

/// Three cranks in the plane z = 0, each with a rod to the platform, and three rows that keep the platform in it.
/// Parameters by leg: x and y of the platform point, offset of the crank's angle, its radius, length of the rod, x and y
/// of its axis.
#[derive(Clone, Debug)]
pub struct Rotary {
    core: MechanismCore,
}

impl Rotary {
    pub fn new() -> Self {
        let (mut specs, mut joints) = (Vec::new(), Vec::new());
        for leg in 0..3 {
            let angle = 2.0 * (leg as f64 - 1.0) * std::f64::consts::FRAC_PI_3;
            let numbers = [0.2 * angle.cos(), 0.2 * angle.sin(), 0.0, 0.4, 0.55, 0.8 * angle.cos(), 0.8 * angle.sin()];
            for (k, (name, nominal)) in ["xA", "yA", "o", "r", "s", "xB", "yB"].iter().zip(numbers).enumerate() {
                let role = match k {
                    0 => ParameterRole::PlatformPoint { leg, axis: Axis::X },
                    1 => ParameterRole::PlatformPoint { leg, axis: Axis::Y },
                    2 => ParameterRole::JointOffset { leg },
                    3 | 4 => ParameterRole::LegDimension { leg },
                    5 => ParameterRole::BasePoint { leg, axis: Axis::X },
                    _ => ParameterRole::BasePoint { leg, axis: Axis::Y },
                };
                let dimension = if k == 2 { Dimension::Angle } else { Dimension::Length };
                let tolerance = Some(if k == 2 { 2e-3 } else { 1e-3 });
                specs.push(ParameterSpec { name: format!("{name}{}", leg + 1), dimension, nominal, tolerance, role });
            }
            let stroke = Some([angle + 2.0, angle + 6.5]);
            joints.push(JointSpec { name: format!("leg{}", leg + 1), dimension: Dimension::Angle, stroke });
        }
        Self { core: MechanismCore::new("planar 3-RRR", specs, joints, Pose::identity()) }
    }
}

impl Mechanism for Rotary {
    fn core(&self) -> &MechanismCore {
        &self.core
    }
    fn with_values(&self, c: &[f64], home: Pose) -> Result<Box<dyn Mechanism>, GeometryError> {
        Ok(Box::new(Self { core: self.core.with_values(c, home)? }))
    }
    fn equations(&self) -> usize {
        6
    }

    fn linearize(&self, c: &[f64], joints: &[f64], pose: &Pose, _at: &Conditions, out: &mut Linearization) {
        out.motion.fill(0.0);
        out.parameters.fill(0.0);
        out.joints.fill(0.0);
        for (leg, p) in c.chunks(PER_LEG).enumerate() {
            let (sin, cos) = (joints[leg] + p[2]).sin_cos();
            let arm = pose.rotation * Vector3::new(p[0], p[1], 0.0);
            let rod = pose.position + arm - Vector3::new(p[5] + p[3] * cos, p[6] + p[3] * sin, 0.0);
            let u = rod.normalize();
            let v = pose.rotation.inverse() * u;
            let turn = arm.cross(&u);
            out.residual[leg] = rod.norm() - p[4];
            for k in 0..3 {
                out.motion[(leg, k)] = u[k];
                out.motion[(leg, k + 3)] = turn[k];
            }
            let along = p[3] * (u.x * sin - u.y * cos);
            let row = [v.x, v.y, along, -(u.x * cos + u.y * sin), -1.0, -u.x, -u.y];
            for (k, value) in row.into_iter().enumerate() {
                out.parameters[(leg, PER_LEG * leg + k)] = value;
            }
            out.joints[(leg, leg)] = along;
        }
        let axis = pose.rotation * Vector3::z();
        out.residual[3] = pose.position.z;
        out.residual[4] = axis.x;
        out.residual[5] = axis.y;
        out.motion[(3, 2)] = 1.0;
        out.motion[(4, 4)] = axis.z;
        out.motion[(4, 5)] = -axis.y;
        out.motion[(5, 3)] = -axis.z;
        out.motion[(5, 5)] = axis.x;
    }

    fn inverse(&self, c: &[f64], pose: &Pose, _at: &Conditions) -> Result<Vec<f64>, KinematicsError> {
        let leg = |p: &[f64]| {
            let d = pose.place(&Vector3::new(p[0], p[1], 0.0)) - Vector3::new(p[5], p[6], 0.0);
            let cos = (p[3] * p[3] + d.norm_squared() - p[4] * p[4]) / (2.0 * p[3] * d.norm());
            // Outwards is far from where the arc tangent jumps.
            (-d.y).atan2(-d.x) + std::f64::consts::PI + cos.acos() - p[2]
        };
        Ok(c.chunks(PER_LEG).map(leg).collect())
    }

    fn forward(&self, c: &[f64], joints: &[f64], at: &Conditions, seed: &Pose) -> Result<Pose, KinematicsError> {
        forward_by_closure(self, c, joints, at, seed)
    }
}

pub fn workspace() -> Workspace {
    let half = [0.08, 0.08, 0.0, 0.0, 0.0, 0.25];
    Workspace { convention: PoseConvention::default(), centre: [0.0; 6], half }
}
