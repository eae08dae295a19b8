//! A mechanism from outside the crate: three legs in a plane, not six, with structural rows.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use paracal::conditions::Conditions;
use paracal::conformance;
use paracal::identification::{IDENTIFIERS, identifier};
use paracal::measurement::Noise;
use paracal::mechanism::{
    Axis, GeometryError, JointSpec, KinematicsError, Linearization, Mechanism, ParameterRole, ParameterSpec, Workspace,
    forward_by_closure,
};
use paracal::nalgebra::Vector3;
use paracal::pose::{Pose, PoseConvention, rotation_vector};
use paracal::units::Dimension;

/// Planar 3-RPR: three legs of variable length in the plane z = 0, and three rows that keep the platform in it.
/// Parameters by leg: x and y of the platform point, offset of the length, x and y of the base point.
#[derive(Clone, Debug)]
struct Planar {
    specs: Vec<ParameterSpec>,
    values: Vec<f64>,
    joints: Vec<JointSpec>,
    home: Pose,
    /// A mistake to be caught: the sign of J2 for the base points' x.
    wrong_sign: bool,
}

impl Planar {
    fn new(wrong_sign: bool) -> Self {
        let (mut specs, mut values, mut joints) = (Vec::new(), Vec::new(), Vec::new());
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
                values.push(nominal);
            }
            joints.push(JointSpec { name: format!("leg{}", leg + 1), dimension: Dimension::Length, stroke: None });
        }
        Self { specs, values, joints, home: Pose::identity(), wrong_sign }
    }
}

impl Mechanism for Planar {
    fn name(&self) -> &str {
        "planar 3-RPR"
    }
    fn parameters(&self) -> &[ParameterSpec] {
        &self.specs
    }
    fn values(&self) -> &[f64] {
        &self.values
    }
    fn with_values(&self, c: &[f64], home: Pose) -> Result<Box<dyn Mechanism>, GeometryError> {
        Ok(Box::new(Self { values: c.to_vec(), home, ..self.clone() }))
    }
    fn joints(&self) -> &[JointSpec] {
        &self.joints
    }
    fn home(&self) -> Pose {
        self.home
    }
    fn equations(&self) -> usize {
        6
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
        let leg =
            |p: &[f64]| (pose.place(&Vector3::new(p[0], p[1], 0.0)) - Vector3::new(p[3], p[4], 0.0)).norm() - p[2];
        Ok(c.chunks(5).map(leg).collect())
    }

    fn forward(&self, c: &[f64], joints: &[f64], at: &Conditions, seed: &Pose) -> Result<Pose, KinematicsError> {
        forward_by_closure(self, c, joints, at, seed)
    }
}

/// The plane: the other three coordinates depend on these.
fn workspace() -> Workspace {
    let half = [0.15, 0.15, 0.0, 0.0, 0.0, 0.3];
    Workspace { convention: PoseConvention::default(), centre: [0.0; 6], half }
}

#[test]
fn a_planar_mechanism_conforms() {
    conformance::mechanism(&Planar::new(false), &workspace()).unwrap();
}

#[test]
fn a_wrong_sign_is_caught_and_named() {
    let found = conformance::mechanism(&Planar::new(true), &workspace()).unwrap_err();
    assert_eq!(found.law, "J2 agrees with differences");
    assert!(found.detail.starts_with("xB1, row 1: analytic"), "{found}");
}

#[test]
fn the_six_hardpoint_mechanisms_conform() {
    for name in ["table2", "table5", "rubin-camera-hexapod", "rubin-m2-hexapod", "nategh-agheli"] {
        let m = common::machine(name);
        conformance::mechanism(m.mechanism.as_ref(), &m.workspace.unwrap()).unwrap_or_else(|v| panic!("{name}: {v}"));
    }
}

#[test]
fn every_identifier_conforms_on_both_mechanisms() {
    let noise = Noise::stated(1e-6, 1e-6);
    let m = common::machine("table5");
    for name in IDENTIFIERS {
        let identifier = identifier(name).unwrap();
        let space = m.workspace.unwrap();
        conformance::identifier(identifier.as_ref(), m.mechanism.as_ref(), &space, &common::paper_noise(), 40)
            .unwrap_or_else(|v| panic!("{name}: {v}"));
        conformance::identifier(identifier.as_ref(), &Planar::new(false), &workspace(), &noise, 30)
            .unwrap_or_else(|v| panic!("{name}, planar: {v}"));
    }
}

#[test]
fn a_planar_pose_is_followed_over_a_large_turn() {
    let m = Planar::new(false);
    let wanted = Pose::from_coordinates(&[0.1, -0.1, 0.0, 0.0, 0.0, -0.5]);
    let at = Conditions::unknown();
    let joints = m.inverse(&m.values, &wanted, &at).unwrap();
    let reached = m.forward(&m.values, &joints, &at, &m.home()).unwrap();
    assert!(rotation_vector(&(wanted.rotation.inverse() * reached.rotation)).norm() < 1e-12);
}
