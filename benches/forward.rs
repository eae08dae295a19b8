//! Forward kinematics through the library against a Newton loop written out by hand.
//!
//! Both solve the same equations from the same start with the same stopping rule. What the library adds is the
//! solver framework, the damping, and the checks that a result is a root on the right branch. The ratio of the
//! two is taken in one run that alternates between them, because single timings on a shared machine differ by
//! more than the two do.

use std::error::Error;
use std::hint::black_box;
use std::time::Duration;

use criterion::Criterion;
use nalgebra::{Matrix6, Rotation3, Vector3, Vector6};
use paracal::conditions::Conditions;
use paracal::files::Machine;
use paracal::mechanism::{ForwardQuery, Leg, Mechanism, SixHardpoint};
use paracal::pose::{Pose, PoseConvention};
use paracal_benches::interleaved;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

const MECHANISM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../mechanisms/table5.toml");
const POSES: usize = 64;
/// Half-ranges about home, m and rad.
const HALF: [f64; 6] = [0.02, 0.02, 0.02, 0.03, 0.03, 0.03];
/// Alternations of the ratio, and passes over all poses in each.
const BATCHES: usize = 2000;
const PASSES: usize = 4;
/// What the library may cost, in units of the loop by hand.
const ALLOWED: f64 = 1.1;
/// What a batch may cost, in units of one by one.
const ALLOWED_BATCH: f64 = 0.4;

/// The loop that someone would write who needs nothing but the root.
fn newton_by_hand(legs: &[Leg], lengths: &[f64], start: &Pose) -> Option<(Vector3<f64>, Rotation3<f64>)> {
    let (mut t, mut turn) = (start.position, start.rotation);
    for _ in 0..50 {
        let (mut residual, mut jacobian) = (Vector6::zeros(), Matrix6::zeros());
        for (i, leg) in legs.iter().enumerate() {
            let arm = turn * leg.platform;
            let along = t + arm - leg.base;
            let length = along.norm();
            let u = along / length;
            let lever = arm.cross(&u);
            residual[i] = length - (lengths[i] + leg.length_offset);
            for k in 0..3 {
                jacobian[(i, k)] = u[k];
                jacobian[(i, k + 3)] = lever[k];
            }
        }
        let step = jacobian.lu().solve(&-residual)?;
        t += Vector3::new(step[0], step[1], step[2]);
        turn = Rotation3::from_scaled_axis(Vector3::new(step[3], step[4], step[5])) * turn;
        if step.amax() < 3e-8 {
            return Some((t, turn));
        }
    }
    None
}

fn main() -> Result<(), Box<dyn Error>> {
    let machine = Machine::read(MECHANISM)?;
    let any: &dyn std::any::Any = machine.mechanism.as_ref();
    let mechanism: &SixHardpoint = any.downcast_ref().ok_or("the file states another kind of mechanism")?;
    let (c, at, legs, home) = (mechanism.values(), Conditions::unknown(), mechanism.to_legs(), mechanism.home());
    let centre = PoseConvention::default().coordinates(&home);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut near = || {
        let q: [f64; 6] = std::array::from_fn(|k| centre[k] + HALF[k] * rng.random_range(-1.0..=1.0));
        mechanism.inverse(c, &Pose::from_coordinates(&q), &at)
    };
    let joints = (0..POSES).map(|_| near()).collect::<Result<Vec<_>, _>>()?;
    for lengths in &joints {
        let (t, turn) = newton_by_hand(&legs, lengths, &home).ok_or("the loop by hand found no pose")?;
        let distance = mechanism.forward(c, lengths, &at, &home)?.motion_to(&Pose { position: t, rotation: turn });
        if !(distance.amax() < 1e-12) {
            return Err(format!("the two differ by {:.1e}", distance.amax()).into());
        }
    }

    let library = || {
        for lengths in &joints {
            let _ = black_box(mechanism.forward(c, black_box(lengths), &at, &home));
        }
    };
    let by_hand = || {
        for lengths in &joints {
            black_box(newton_by_hand(&legs, black_box(lengths), &home));
        }
    };
    let queries: Vec<ForwardQuery<'_>> = joints.iter().map(|j| ForwardQuery::new(j, &at, home)).collect();
    let batch = || black_box(mechanism.forward_batch(c, black_box(&queries)));
    for (query, found) in queries.iter().zip(batch()) {
        let distance = mechanism.forward(c, query.joints, &at, &home)?.motion_to(&found?);
        if !(distance.amax() < 1e-12) {
            return Err(format!("the batch differs by {:.1e}", distance.amax()).into());
        }
    }
    let brief = Criterion::default().warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
    let mut criterion = brief.configure_from_args();
    let mut group = criterion.benchmark_group("forward, 64 poses near home");
    group.bench_function("library", |b| b.iter(library));
    group.bench_function("by hand", |b| b.iter(by_hand));
    group.bench_function("in batches", |b| b.iter(batch));
    group.finish();
    // Without this argument criterion only checks that everything runs.
    if std::env::args().any(|a| a == "--bench") {
        let (a, b, median) = interleaved(BATCHES, PASSES, library, by_hand);
        let micro = |d: Duration| 1e6 * d.as_secs_f64() / (PASSES * POSES) as f64;
        let ratio = a.as_secs_f64() / b.as_secs_f64();
        println!(
            "forward kinematics, interleaved: library {:.3} us, by hand {:.3} us per pose; ratio {ratio:.2} of the \
             minima, {median:.2} in the median (at most {ALLOWED} wanted)",
            micro(a),
            micro(b)
        );
        let (a, b, median) = interleaved(BATCHES, PASSES, batch, library);
        let ratio = a.as_secs_f64() / b.as_secs_f64();
        println!(
            "in batches, interleaved: {:.3} us, one by one {:.3} us per pose; ratio {ratio:.2} of the minima, \
             {median:.2} in the median (at most {ALLOWED_BATCH} wanted)",
            micro(a),
            micro(b)
        );
    }
    criterion.final_summary();
    Ok(())
}
