//! Mechanisms from one closure function: the four kinds, and the paper's mechanism against its closed form.

use crate::common;

use std::any::Any;

use crate::common::kinds;
use paracal::conditions::Conditions;
use paracal::conformance;
use paracal::mechanism::{Linearization, Mechanism, MotionBlock, SixHardpoint};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

#[test]
fn every_kind_conforms() {
    for (m, space) in kinds::all() {
        conformance::mechanism(m.as_ref(), &space).unwrap_or_else(|v| panic!("{}: {v}", m.name()));
    }
}

#[test]
fn closed_form_and_closure_of_the_six_hardpoint_agree() {
    for name in ["table2", "table5", "rubin-camera-hexapod", "rubin-m2-hexapod", "nategh-agheli"] {
        let machine = common::machine(name);
        let closed = machine.mechanism.as_ref();
        let space = machine.workspace.unwrap();
        let legs = (closed as &dyn Any).downcast_ref::<SixHardpoint>().unwrap().to_legs();
        let closure = kinds::hardpoint(&legs, closed.home());
        conformance::mechanism(&closure, &space).unwrap_or_else(|v| panic!("{name}: {v}"));
        let at = Conditions::unknown();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for _ in 0..50 {
            let pose = space.random(&mut rng);
            // Values that are not the nominal ones, so that every parameter plays its part.
            let c: Vec<f64> = closed.values().iter().enumerate().map(|(k, v)| v + 1e-4 * (k as f64).sin()).collect();
            let joints = closed.inverse(&c, &pose, &at).unwrap();
            let again = closure.inverse(&c, &pose, &at).unwrap();
            joints.iter().zip(&again).for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{name}: {a} {b}"));
            let (mut a, mut b) = (Linearization::sized_for(closed), Linearization::sized_for(&closure));
            closed.linearize(&c, &joints, &pose, &at, &mut a);
            closure.linearize(&c, &joints, &pose, &at, &mut b);
            let worst = (&a.motion - &b.motion).amax().max((&a.parameters - &b.parameters).amax());
            assert!(worst.max((&a.joints - &b.joints).amax()) < 1e-13, "{name}: {worst:.1e}");
            let (mut a, mut b) = (MotionBlock::sized_for(closed), MotionBlock::sized_for(&closure));
            closed.motion_block(&c, &joints, &pose, &at, &mut a).unwrap();
            closure.motion_block(&c, &joints, &pose, &at, &mut b).unwrap();
            let size = a.parameters.amax().max(1.0);
            assert!((&a.parameters - &b.parameters).amax() < 1e-11 * size, "{name}");
            let (p, q) =
                (closed.forward(&c, &joints, &at, &closed.home()), closure.forward(&c, &joints, &at, &closed.home()));
            assert!(p.unwrap().motion_to(&q.unwrap()).amax() < 1e-11, "{name}");
        }
    }
}
