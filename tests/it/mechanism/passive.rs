//! Passive coordinates: a hexapod whose universal joints have axes that do not meet, as in many real ones.

use crate::common::{kinds, machine};
use paracal::conditions::Conditions;
use paracal::conformance;
use paracal::mechanism::closure::{Closure, ClosureMechanism, Outline, Real, State};
use paracal::mechanism::{GeometryError, KinematicsError, Mechanism, ParameterRole, SixHardpoint};
use paracal::nalgebra::Vector3;
use paracal::units::Dimension;

/// Leg `i`: the first axis `u` is fixed in the base at `b`, the second stands `e` away along the leg's first arm. The
/// passive angles are the turns about the two axes; three equations say that the tip meets the platform.
#[derive(Clone, Debug)]
struct OffsetJoints {
    /// At home: first axis, direction of the leg, and their cross product.
    frames: Vec<[Vector3<f64>; 3]>,
}

impl Closure for OffsetJoints {
    fn residual<T: Real>(&self, s: &State<'_, T>, out: &mut [T]) {
        for (leg, [u, w, v]) in self.frames.iter().enumerate() {
            let c = 7 * leg;
            let (sin1, cos1) = s.passive[2 * leg].sin_cos();
            let (sin2, cos2) = s.passive[2 * leg + 1].sin_cos();
            let offset = s.parameters[c + 6];
            // After the turn about u the arm points along cos w + sin v; the second axis is perpendicular to both.
            let arm = Vector3::from_fn(|k, _| cos1 * w[k] + sin1 * v[k]);
            let along = Vector3::from_fn(|k, _| cos2 * arm[k] + sin2 * u[k]);
            let gap = s.place(&s.point(c)) - s.point(c + 3);
            for k in 0..3 {
                out[3 * leg + k] = gap[k] - offset * arm[k] - s.joints[leg] * along[k];
            }
        }
    }
}

fn hexapod(offset: f64) -> ClosureMechanism<OffsetJoints> {
    let m = machine("table5");
    let legs = (m.mechanism.as_ref() as &dyn std::any::Any).downcast_ref::<SixHardpoint>().unwrap().to_legs();
    let home = m.mechanism.home();
    let mut outline = Outline::new("hexapod with offset joints", 18, home).passive(&[0.0; 12]);
    let mut frames = Vec::new();
    for (leg, l) in legs.iter().enumerate() {
        let gap = home.place(&l.platform) - l.base;
        let w = gap.normalize();
        let u = Vector3::z().cross(&w).normalize();
        frames.push([u, w, u.cross(&w)]);
        outline = outline
            .platform_point(leg, l.platform.into(), None)
            .base_point(leg, l.base.into(), None)
            .parameter(format!("e{}", leg + 1), Dimension::Length, offset, None, ParameterRole::LegDimension { leg })
            .joint(format!("leg{}", leg + 1), Dimension::Length, gap.norm() - offset, None);
    }
    ClosureMechanism::new(OffsetJoints { frames }, outline).unwrap()
}

#[test]
fn passive_coordinates_are_eliminated() {
    let m = hexapod(0.03);
    assert_eq!(m.equations(), 6);
    let space = kinds::about(&m.home(), [0.05, 0.05, 0.05, 0.06, 0.06, 0.06]);
    conformance::mechanism(&m, &space).unwrap();
}

#[test]
fn without_an_offset_they_change_nothing_and_with_one_what_geometry_says() {
    let plain = machine("table5").mechanism;
    let (none, some) = (hexapod(0.0), hexapod(0.03));
    let at = Conditions::unknown();
    let pose = plain.home().moved(&paracal::nalgebra::Vector6::new(0.04, -0.03, 0.05, 0.04, -0.05, 0.06));
    let (a, b) = (plain.inverse(plain.values(), &pose, &at).unwrap(), none.inverse(none.values(), &pose, &at).unwrap());
    a.iter().zip(&b).for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{a} {b}"));
    // In the plane perpendicular to the first axis the leg is seen without its part along it; the offset shortens that.
    let lengths = some.inverse(some.values(), &pose, &at).unwrap();
    for (leg, [u, ..]) in some.closure().frames.iter().enumerate() {
        let c = &some.values()[7 * leg..];
        let gap = pose.place(&Vector3::new(c[0], c[1], c[2])) - Vector3::new(c[3], c[4], c[5]);
        let across = gap.dot(u);
        let seen = (gap.norm_squared() - across * across).sqrt() - 0.03;
        assert!((lengths[leg] - seen.hypot(across)).abs() < 1e-12, "leg {}", leg + 1);
    }
}

#[derive(Clone, Debug)]
struct Lies;

impl Closure for Lies {
    fn residual<T: Real>(&self, s: &State<'_, T>, out: &mut [T]) {
        for k in 0..3 {
            out[k] = s.position[k] - s.joints[k] - s.parameters[0] * 0.1;
            out[k + 3] = s.rotation[((k + 1) % 3, k)] - s.joints[k + 3];
        }
    }
    fn depends(&self, row: usize, on: paracal::mechanism::closure::Column) -> bool {
        matches!(on, paracal::mechanism::closure::Column::Joint(k) if k == row) || row == 0
    }
}

#[test]
fn what_a_closure_says_of_its_sparsity_is_checked() {
    let mut outline = Outline::new("gantry", 6, paracal::pose::Pose::identity());
    for axis in 1..=6 {
        outline = outline.joint(format!("axis{axis}"), Dimension::Length, 0.0, None);
    }
    let outline = outline.parameter("k", Dimension::Length, 0.0, None, ParameterRole::Other);
    match ClosureMechanism::new(Lies, outline) {
        Err(GeometryError::HiddenDependence { row: 2, column, .. }) => assert_eq!(column, "k"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_pose_out_of_reach_is_refused() {
    let m = kinds::rotary();
    let far = paracal::pose::Pose::from_coordinates(&[0.0, 0.0, 2.0, 0.0, 0.0, 0.0]);
    let refused = m.inverse(m.values(), &far, &Conditions::unknown());
    assert!(matches!(refused, Err(KinematicsError::NoRoot { .. })), "{refused:?}");
}
