//! Many poses at a time against one at a time.

use crate::common::{machine, workspace};
use paracal::conditions::Conditions;
use paracal::mechanism::{ForwardQuery, KinematicsError, Mechanism};
use paracal::pose::Pose;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Joints of random poses, parameters that differ from the drawing, and seeds that may be far away.
fn queries(m: &dyn Mechanism, rng: &mut ChaCha8Rng, count: usize) -> (Vec<f64>, Vec<Vec<f64>>, Vec<Pose>) {
    let space = workspace(m, 40.0, 4.0);
    let c: Vec<f64> = m.values().iter().map(|v| v + rng.random_range(-1e-4..1e-4)).collect();
    let pose = |rng: &mut ChaCha8Rng| space.random(rng);
    let joints = (0..count).map(|_| m.inverse(&c, &pose(rng), &Conditions::unknown()).unwrap()).collect();
    (c, joints, (0..count).map(|k| if k % 3 == 0 { pose(rng) } else { m.home() }).collect())
}

fn distance(a: &Pose, b: &Pose) -> f64 {
    a.motion_to(b).amax()
}

#[test]
fn roots_are_those_of_one_at_a_time() {
    let at = Conditions::unknown();
    for name in ["table5", "nategh-agheli", "rubin-m2-hexapod"] {
        let machine = machine(name);
        let m = machine.mechanism.as_ref();
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        for count in [1, 7, 16, 133] {
            let (c, joints, seeds) = queries(m, &mut rng, count);
            let all: Vec<ForwardQuery<'_>> =
                joints.iter().zip(&seeds).map(|(j, seed)| ForwardQuery::new(j, &at, *seed)).collect();
            let found = m.forward_batch(&c, &all);
            assert_eq!(found.len(), count);
            for (q, found) in all.iter().zip(found) {
                let alone = m.forward(&c, q.joints, q.at, &q.seed).unwrap();
                assert!(distance(&found.unwrap(), &alone) < 1e-13);
            }
        }
    }
}

#[test]
fn a_root_does_not_depend_on_its_neighbours() {
    let machine = machine("table5");
    let m = machine.mechanism.as_ref();
    let at = Conditions::unknown();
    let (c, joints, seeds) = queries(m, &mut ChaCha8Rng::seed_from_u64(12), 40);
    let query = |k: usize| ForwardQuery::new(&joints[k], &at, seeds[k]);
    let all: Vec<ForwardQuery<'_>> = (0..40).map(query).collect();
    let whole = m.forward_batch(&c, &all);
    // The order of elimination is that of the first seed, so that it stays first.
    let order: Vec<usize> = std::iter::once(0).chain((1..40).rev().step_by(3)).collect();
    let some: Vec<ForwardQuery<'_>> = order.iter().map(|k| query(*k)).collect();
    for (k, pose) in order.iter().zip(m.forward_batch(&c, &some)) {
        assert_eq!(pose.unwrap(), *whole[*k].as_ref().unwrap());
    }
}

#[test]
fn what_has_no_root_gives_the_same_error_and_spoils_no_other() {
    let machine = machine("table5");
    let m = machine.mechanism.as_ref();
    let at = Conditions::unknown();
    let (c, mut joints, seeds) = queries(m, &mut ChaCha8Rng::seed_from_u64(13), 20);
    joints[3] = vec![0.1, 3.0, 0.1, 3.0, 0.1, 3.0];
    joints[5][2] = f64::NAN;
    joints[9] = vec![0.9; 6];
    let all: Vec<ForwardQuery<'_>> =
        joints.iter().zip(&seeds).map(|(j, seed)| ForwardQuery::new(j, &at, *seed)).collect();
    let found = m.forward_batch(&c, &all);
    for (q, found) in all.iter().zip(&found) {
        match (m.forward(&c, q.joints, q.at, &q.seed), found) {
            (Ok(alone), Ok(found)) => assert!(distance(found, &alone) < 1e-13),
            (alone, found) => assert_eq!(&alone, found),
        }
    }
    assert!(found[3].is_err() && matches!(found[5], Err(KinematicsError::NotFinite { .. })));
    joints[7].pop();
    let all: Vec<ForwardQuery<'_>> =
        joints.iter().zip(&seeds).map(|(j, seed)| ForwardQuery::new(j, &at, *seed)).collect();
    let found = m.forward_batch(&c, &all);
    assert!(matches!(found[7], Err(KinematicsError::JointCount { expected: 6, found: 5 })) && found[8].is_ok());
}
