//! Forward kinematics over the whole box of the paper, and beyond reach.

use crate::common::{machine, workspace};
use paracal::conditions::Conditions;
use paracal::mechanism::KinematicsError;
use paracal::simulation::monte_carlo;

#[test]
fn a_million_random_poses_come_back() {
    let m = machine("table5").mechanism;
    let space = workspace(m.as_ref(), 100.0, 10.0);
    let at = Conditions::unknown();
    const CHUNK: u64 = 1000;
    let worst = monte_carlo(1_000_000 / CHUNK, 31, |_, rng| {
        let mut worst = 0.0_f64;
        for _ in 0..CHUNK {
            let pose = space.random(rng);
            let joints = m.inverse(m.values(), &pose, &at).unwrap();
            let back = m.forward(m.values(), &joints, &at, &m.home()).unwrap();
            worst = worst.max(pose.motion_to(&back).amax());
        }
        worst
    });
    let worst = worst.into_iter().fold(0.0, f64::max);
    // 1e-10 mm; the same number in rad is far below what a tracker sees.
    assert!(worst <= 1e-13, "{worst:.2e} m or rad");
}

#[test]
fn lengths_out_of_reach_are_an_error_with_numbers() {
    let m = machine("table5").mechanism;
    let at = Conditions::unknown();
    let home = m.inverse(m.values(), &m.home(), &at).unwrap();
    for (leg, length) in [(0, 3.0), (3, 0.01), (5, 2.0)] {
        let mut joints = home.clone();
        joints[leg] = length;
        let error = m.forward(m.values(), &joints, &at, &m.home()).unwrap_err();
        let KinematicsError::OutOfReach { percent, .. } = error else { panic!("{error}") };
        assert!((0.0..100.0).contains(&percent));
        assert!(error.to_string().contains("out of reach"), "{error}");
    }
    let mut joints = home;
    joints[2] = f64::INFINITY;
    assert!(matches!(m.forward(m.values(), &joints, &at, &m.home()), Err(KinematicsError::NotFinite { .. })));
}
