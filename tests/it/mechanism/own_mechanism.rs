//! A mechanism from outside the crate: three legs in a plane, not six, with structural rows.

use crate::common;

use crate::common::planar::{Planar, workspace};
use crate::common::rotary;
use paracal::conditions::Conditions;
use paracal::conformance;
use paracal::identification::{IDENTIFIERS, identifier};
use paracal::measurement::Noise;
use paracal::mechanism::Mechanism;
use paracal::pose::{Pose, rotation_vector};

#[test]
fn a_planar_mechanism_conforms() {
    conformance::mechanism(&Planar::new(false), &workspace()).unwrap();
}

#[test]
fn a_mechanism_with_cranks_conforms() {
    conformance::mechanism(&rotary::Rotary::new(), &rotary::workspace()).unwrap();
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
    let m = paracal::files::Machine::read(common::path("mechanisms/desk-hexapod.urdf")).unwrap();
    conformance::mechanism(m.mechanism.as_ref(), &m.workspace.unwrap()).unwrap();
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
    let joints = m.inverse(m.values(), &wanted, &at).unwrap();
    let reached = m.forward(m.values(), &joints, &at, &m.home()).unwrap();
    assert!(rotation_vector(&(wanted.rotation.inverse() * reached.rotation)).norm() < 1e-12);
}
