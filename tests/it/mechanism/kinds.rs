//! Calibration and selection of the closure-defined kinds, from simulated data: the generator moves joints and solves
//! the full forward kinematics of the true mechanism.

use crate::common::{kinds, text};
use paracal::conditions::Conditions;
use paracal::conformance;
use paracal::files::Machine;
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, PriorPolicy, Task, calibrate, identifier};
use paracal::measurement::Noise;
use paracal::mechanism::{Linearization, Mechanism, Workspace, consistent};
use paracal::nalgebra::{DMatrix, Matrix6};
use paracal::pose::Pose;
use paracal::simulation::{as_dataset, draw_parameters, simulate};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

fn poses(m: &dyn Mechanism, space: &Workspace, count: usize, seed: u64) -> Vec<Pose> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let at = Conditions::unknown();
    std::iter::from_fn(|| Some(consistent(m, m.values(), &space.random(&mut rng), &at).ok().map(|(pose, _)| pose)))
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
        let run =
            simulate(nominal, truth.as_ref(), &at, &space.convention, &Noise::stated(0.0, 0.0), &mut rng).unwrap();
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

#[test]
fn noisy_data_reach_their_covariance() {
    for (mut m, space) in kinds::all() {
        if m.name() == "linear delta" {
            // A platform that never turns cannot tell its own points from those of the carriages.
            m = Box::new(kinds::delta().identifying(|p| !p.name.contains('A')).unwrap());
        }
        if m.name() == "Rotary delta" {
            let text = text("mechanisms/rotary-delta.toml");
            let some =
                text.replacen("\n\n[[leg]]", "\nidentify = [\"xB\", \"yB\", \"zB\", \"s\", \"o\"]\n\n[[leg]]", 1);
            m = Machine::from_text(&some, "m.toml".as_ref()).unwrap().mechanism;
        }
        // Cables are read with noise: their lengths say more than the pose needs.
        let noise = Noise { joint: if m.equations() > 6 { 1e-6 } else { 0.0 }, ..Noise::stated(1e-7, 3e-7) };
        for name in ["levenberg-marquardt", "least-squares"] {
            let chosen = identifier(name).unwrap();
            conformance::identifier(chosen.as_ref(), m.as_ref(), &space, &noise, 60)
                .unwrap_or_else(|v| panic!("{name}, {}: {v}", m.name()));
        }
    }
}

/// The information of the closure residual itself, whose covariance is `J1 Σq J1ᵀ + Jj Σj Jjᵀ`.
#[test]
fn a_redundant_closure_loses_nothing() {
    let m = kinds::cables();
    let space = kinds::about(&m.home(), [0.3, 0.3, 0.0, 0.0, 0.0, 0.2]);
    let noise = Noise { joint: 2e-4, ..Noise::stated(3e-6, 1e-5) };
    let at = poses(&m, &space, 30, 8);
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let exact = Noise::stated(0.0, 0.0);
    let data =
        as_dataset(&simulate(&m, &m, &at, &space.convention, &exact, &mut rng).unwrap(), &space.convention, &noise);
    let found = identifier("levenberg-marquardt").unwrap();
    let found = found.identify(&Task { prior: PriorPolicy::None, ..Task::new(&m, &data) }).unwrap();
    let sigma_q = Matrix6::from_diagonal(&[3e-6, 3e-6, 3e-6, 1e-5, 1e-5, 1e-5].map(|s: f64| s * s).into());
    let n = m.parameters().len();
    let mut information = DMatrix::zeros(n, n);
    for pose in &at {
        let joints = m.inverse(m.values(), pose, &Conditions::unknown()).unwrap();
        let mut rows = Linearization::sized_for(&m);
        m.linearize(m.values(), &joints, pose, &Conditions::unknown(), &mut rows);
        // The platform is upright in the plane: angles and rotation vector are the same to first order.
        let covariance = &rows.motion * sigma_q * rows.motion.transpose()
            + &rows.joints * rows.joints.transpose() * noise.joint.powi(2);
        information += rows.parameters.transpose() * covariance.try_inverse().unwrap() * &rows.parameters;
    }
    let expected = information.try_inverse().unwrap();
    for (k, p) in found.parameters.iter().enumerate() {
        let ratio = p.sigma.unwrap() / expected[(k, k)].sqrt();
        assert!((ratio - 1.0).abs() < 1e-4, "{}: {ratio}", p.spec.name);
    }
}
