//! What it costs to state a mechanism by one closure function: motion blocks `J_b` of the paper's mechanism by dual
//! numbers against the closed form, in one run that alternates between them; and forward kinematics likewise.

// The mechanism that the tests compare with the closed form, too.
#[allow(dead_code, missing_docs, unreachable_pub, clippy::unwrap_used)]
#[path = "../tests/it/common/kinds.rs"]
mod kinds;

use std::error::Error;
use std::hint::black_box;
use std::time::Duration;

use criterion::Criterion;
use paracal::conditions::Conditions;
use paracal::files::Machine;
use paracal::mechanism::{Mechanism, MotionBlock, SixHardpoint};
use paracal::pose::Pose;
use paracal_benches::interleaved;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

const MECHANISM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../mechanisms/table5.toml");
const POSES: usize = 64;
const BATCHES: usize = 1000;
/// What a motion block may cost, in units of the closed form.
const ALLOWED: f64 = 4.0;

fn main() -> Result<(), Box<dyn Error>> {
    let machine = Machine::read(MECHANISM)?;
    let space = machine.workspace.ok_or("the file states no workspace")?;
    let any: &dyn std::any::Any = machine.mechanism.as_ref();
    let closed: &SixHardpoint = any.downcast_ref().ok_or("the file states another kind of mechanism")?;
    let closure = kinds::hardpoint(&closed.to_legs(), closed.home());
    let (c, at) = (closed.values(), Conditions::unknown());
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let poses: Vec<Pose> = (0..POSES).map(|_| space.random(&mut rng)).collect();
    let joints = poses.iter().map(|p| closed.inverse(c, p, &at)).collect::<Result<Vec<_>, _>>()?;
    let blocks = |m: &dyn Mechanism, out: &mut MotionBlock| {
        for (pose, joints) in poses.iter().zip(&joints) {
            let _ = black_box(m.motion_block(c, black_box(joints), pose, &at, out));
            black_box(&out);
        }
    };
    let forward = |m: &dyn Mechanism| {
        for joints in &joints {
            let _ = black_box(m.forward(c, black_box(joints), &at, &closed.home()));
        }
    };
    let (mut a, mut b) = (MotionBlock::sized_for(closed), MotionBlock::sized_for(closed));
    let brief = Criterion::default().warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
    let mut criterion = brief.configure_from_args();
    let mut group = criterion.benchmark_group("motion blocks, 64 poses");
    group.bench_function("closure", |t| t.iter(|| blocks(&closure, &mut a)));
    group.bench_function("closed form", |t| t.iter(|| blocks(closed, &mut b)));
    group.finish();
    // Without this argument criterion only checks that everything runs.
    if std::env::args().any(|a| a == "--bench") {
        let micro = |d: Duration| 1e6 * d.as_secs_f64() / POSES as f64;
        let say = |what: &str, (a, b, median): (Duration, Duration, f64), wanted: &str| {
            let ratio = a.as_secs_f64() / b.as_secs_f64();
            println!(
                "{what}, interleaved: closure {:.3} us, closed form {:.3} us; ratio {ratio:.2} of the minima, {median:.2} \
                 in the median{wanted}",
                micro(a),
                micro(b)
            );
        };
        let wanted = format!(" (at most {ALLOWED} wanted)");
        say("motion block", interleaved(BATCHES, 1, || blocks(&closure, &mut a), || blocks(closed, &mut b)), &wanted);
        say("forward kinematics", interleaved(BATCHES, 1, || forward(&closure), || forward(closed)), "");
    }
    criterion.final_summary();
    Ok(())
}
