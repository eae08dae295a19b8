//! A mechanism from outside the crate that has no leg structure: a planar 3-RPR.

use paracal::conditions::Conditions;
use paracal::mechanism::{
    Axis, GeometryError, JointSpec, KinematicsError, Linearization, Mechanism, MechanismCore, ParameterRole,
    ParameterSpec, Workspace, forward_by_closure,
};
use paracal::nalgebra::Vector3;
use paracal::pose::{Pose, PoseConvention};
use paracal::units::Dimension;

/// Planar 3-RPR: three legs of variable length in the plane z = 0, and three rows that keep the platform in it.
/// Parameters by leg: x and y of the platform point, offset of the length, x and y of the base point.
#[derive(Clone, Debug)]
pub struct Planar {
    core: MechanismCore,
    /// A mistake to be caught: the sign of J2 for the base points' x.
    wrong_sign: bool,
}

impl Planar {
    pub fn new(wrong_sign: bool) -> Self {
        let (mut specs, mut joints) = (Vec::new(), Vec::new());
        for leg in 0..3 {
            // The platform is turned against the base: legs that meet in one point would not hold it.
            let (angle, turned) = (2.1 * leg as f64, 2.1 * leg as f64 + 0.9);
            let numbers = [0.2 * turned.cos(), 0.2 * turned.sin(), 0.0, angle.cos(), 0.9 * angle.sin()];
            for (k, (name, nominal)) in ["xA", "yA", "h", "xB", "yB"].iter().zip(numbers).enumerate() {
                let role = match k {
                    0 => ParameterRole::PlatformPoint { leg, axis: Axis::X },
                    1 => ParameterRole::PlatformPoint { leg, axis: Axis::Y },
                    2 => ParameterRole::JointOffset { leg },
                    3 => ParameterRole::BasePoint { leg, axis: Axis::X },
                    _ => ParameterRole::BasePoint { leg, axis: Axis::Y },
                };
                let name = format!("{name}{}", leg + 1);
                specs.push(ParameterSpec { name, dimension: Dimension::Length, nominal, tolerance: Some(1e-3), role });
            }
            joints.push(JointSpec { name: format!("leg{}", leg + 1), dimension: Dimension::Length, stroke: None });
        }
        Self { core: MechanismCore::new("planar 3-RPR", specs, joints, Pose::identity()), wrong_sign }
    }
}

impl Mechanism for Planar {
    fn core(&self) -> &MechanismCore {
        &self.core
    }
    fn with_values(&self, c: &[f64], home: Pose) -> Result<Box<dyn Mechanism>, GeometryError> {
        Ok(Box::new(Self { core: self.core.with_values(c, home)?, ..*self }))
    }
    fn equations(&self) -> usize {
        6
    }
    fn controlled(&self) -> [bool; 6] {
        [true, true, false, false, false, true]
    }

    fn linearize(&self, c: &[f64], joints: &[f64], pose: &Pose, _at: &Conditions, out: &mut Linearization) {
        out.motion.fill(0.0);
        out.parameters.fill(0.0);
        out.joints.fill(0.0);
        for leg in 0..3 {
            let p = &c[5 * leg..5 * leg + 5];
            let arm = pose.rotation * Vector3::new(p[0], p[1], 0.0);
            let l = pose.position + arm - Vector3::new(p[3], p[4], 0.0);
            let u = l.normalize();
            let v = pose.rotation.inverse() * u;
            let turn = arm.cross(&u);
            out.residual[leg] = l.norm() - joints[leg] - p[2];
            for k in 0..3 {
                out.motion[(leg, k)] = u[k];
                out.motion[(leg, k + 3)] = turn[k];
            }
            let sign = if self.wrong_sign { 1.0 } else { -1.0 };
            for (k, value) in [v.x, v.y, -1.0, sign * u.x, -u.y].into_iter().enumerate() {
                out.parameters[(leg, 5 * leg + k)] = value;
            }
            out.joints[(leg, leg)] = -1.0;
        }
        // In the plane: z = 0 and no tilt of the platform's z axis.
        let axis = pose.rotation * Vector3::z();
        out.residual[3] = pose.position.z;
        out.residual[4] = axis.x;
        out.residual[5] = axis.y;
        out.motion[(3, 2)] = 1.0;
        // d(axis) = ω × axis
        out.motion[(4, 4)] = axis.z;
        out.motion[(4, 5)] = -axis.y;
        out.motion[(5, 3)] = -axis.z;
        out.motion[(5, 5)] = axis.x;
    }

    fn inverse(&self, c: &[f64], pose: &Pose, _at: &Conditions) -> Result<Vec<f64>, KinematicsError> {
        // Only what the joints control: the platform stays in its plane.
        let [x, y, .., gamma] = pose.coordinates();
        let pose = Pose::from_coordinates(&[x, y, 0.0, 0.0, 0.0, gamma]);
        let leg =
            |p: &[f64]| (pose.place(&Vector3::new(p[0], p[1], 0.0)) - Vector3::new(p[3], p[4], 0.0)).norm() - p[2];
        Ok(c.chunks(5).map(leg).collect())
    }

    fn forward(&self, c: &[f64], joints: &[f64], at: &Conditions, seed: &Pose) -> Result<Pose, KinematicsError> {
        forward_by_closure(self, c, joints, at, seed)
    }
}

/// The plane: the other three coordinates depend on these.
pub fn workspace() -> Workspace {
    let half = [0.15, 0.15, 0.0, 0.0, 0.0, 0.3];
    Workspace { convention: PoseConvention::default(), centre: [0.0; 6], half }
}
