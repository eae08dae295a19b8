//! Calibration and selection of the closure-defined kinds, from simulated data: the generator moves joints and solves
//! the full forward kinematics of the true mechanism.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::kinds;
use paracal::conditions::Conditions;
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, calibrate};
use paracal::measurement::Noise;
use paracal::mechanism::{Mechanism, Workspace, settled};
use paracal::pose::Pose;
use paracal::simulation::{as_dataset, draw_parameters, simulate};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

fn poses(m: &dyn Mechanism, space: &Workspace, count: usize, seed: u64) -> Vec<Pose> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let at = Conditions::unknown();
    std::iter::from_fn(|| Some(settled(m, m.values(), &space.random(&mut rng), &at).ok().map(|(pose, _)| pose)))
        .flatten()
        .take(count)
        .collect()
}

/// Largest distance between two mechanisms at new poses, commanded alike: m and rad alike.
fn distance(a: &dyn Mechanism, b: &dyn Mechanism, space: &Workspace) -> f64 {
    let at = Conditions::unknown();
    let there = |pose: &Pose| {
        let joints = a.inverse(a.values(), pose, &at).unwrap();
        let (p, q) = (a.forward(a.values(), &joints, &at, pose), b.forward(b.values(), &joints, &at, pose));
        p.unwrap().motion_to(&q.unwrap()).amax()
    };
    poses(a, space, 100, 99).iter().map(there).fold(0.0, f64::max)
}

#[test]
fn exact_data_give_the_mechanism_back() {
    for (m, space) in kinds::all() {
        let nominal = m.as_ref();
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let values = draw_parameters(nominal, None, &mut rng);
        let truth = nominal.with_values(&values, nominal.home()).unwrap();
        let noise = Noise::stated(1e-9, 1e-9);
        let at = poses(nominal, &space, 80, 1);
        let run = simulate(nominal, truth.as_ref(), &at, &space.convention, &Noise::stated(0.0, 0.0), &mut rng).unwrap();
        let data = as_dataset(&run, &space.convention, &noise);
        let before = distance(nominal, truth.as_ref(), &space);
        let result =
            calibrate(nominal, &data, Some(&space), &LevenbergMarquardt::default(), &CalibrationOptions::default())
                .unwrap();
        let after = distance(result.mechanism.as_ref(), truth.as_ref(), &space);
        println!("{}: {before:.1e} -> {after:.1e}, {} weak: {:?}", nominal.name(), result.weak.len(), result.weak);
        assert!(!result.registration.applied);
        let unseen = result.weak.len();
        let off = result.parameters.iter().zip(&values).filter(|(p, v)| (p.value - **v).abs() > 1e-7).count();
        println!("   off {off}, trusted {:?} {:?}", result.verdict.trusted, result.verdict.reasons);
        assert!(after < 1e-8 && before > 1e-5, "{}: {before:.1e} -> {after:.1e}", nominal.name());
        assert!(unseen > 0 || off == 0, "{}: {off} parameters are off", nominal.name());
    }
}
