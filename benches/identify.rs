//! One calibration against one singular value decomposition, and Monte Carlo on one and two threads.
//!
//! The yardstick is a single linear solve by SVD of the system that a calibration of 20 poses has, 120 rows and
//! 42 unknowns: the least that any method must pay which treats the problem as linear. The ratio is taken in one
//! run that alternates between the two, because single timings on a shared machine differ by more than they do.

use std::error::Error;
use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::Criterion;
use nalgebra::{DMatrix, DVector};
use paracal::files::{Machine, read_measurement};
use paracal::identification::{
    CalibrationOptions, CalibrationProblem, IdentifyError, LevenbergMarquardt, Task, calibrate as calibrate_whole,
};
use paracal::measurement::{Dataset, Noise};
use paracal::mechanism::Mechanism;
use paracal::pose::{Pose, PoseConvention};
use paracal::simulation::{as_dataset, draw_parameters, monte_carlo, simulate};
use paracal::solve::{
    LeastSquaresMethod, LeastSquaresOptions, LeastSquaresProblem, LeastSquaresSolution, least_squares,
};
use paracal_benches::interleaved;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rayon::{ThreadPool, ThreadPoolBuilder};

const MECHANISM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../mechanisms/table5.toml");
const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/data/hardpoint-noisy.csv");
/// Alternations of the ratio.
const BATCHES: usize = 1000;
/// What a calibration may cost, in units of the SVD.
const ALLOWED: f64 = 1.5;
/// Simulated calibrations, and how often each number of threads has its turn.
const DRAWS: u64 = 2000;
const TURNS: usize = 10;
/// 1σ of the drawn parameters, m.
const ERROR: f64 = 0.5e-3;
const WANTED_SPEED_UP: f64 = 1.9;

fn calibrate(mechanism: &dyn Mechanism, data: &Dataset) -> Result<LeastSquaresSolution, IdentifyError> {
    let mut problem = CalibrationProblem::new(&Task::new(mechanism, data))?;
    let start = problem.start();
    let options = LeastSquaresOptions::default();
    least_squares(&mut problem, start, LeastSquaresMethod::LevenbergMarquardt, &options).map_err(IdentifyError::from)
}

/// Residual and whitened Jacobian at the start.
fn system(mechanism: &dyn Mechanism, data: &Dataset) -> Result<(DVector<f64>, DMatrix<f64>), Box<dyn Error>> {
    let mut problem = CalibrationProblem::new(&Task::new(mechanism, data))?;
    let ((m, n), start) = (problem.shape(), problem.start());
    let (mut r, mut j) = (DVector::zeros(m), DMatrix::zeros(m, n));
    problem.linearize(&start, &mut r, &mut j)?;
    Ok((r, j))
}

fn solve_by_svd(j: &DMatrix<f64>, r: &DVector<f64>) -> Result<DVector<f64>, &'static str> {
    j.clone().svd(true, true).solve(r, 0.0)
}

/// Largest error of a parameter after calibrating a mechanism with drawn errors, m.
fn simulated_calibration(
    mechanism: &dyn Mechanism,
    poses: &[Pose],
    noise: &Noise,
    rng: &mut ChaCha8Rng,
) -> Result<f64, Box<dyn Error + Send + Sync>> {
    let convention = PoseConvention::default();
    let drawn = draw_parameters(mechanism, Some(ERROR), rng);
    let truth = mechanism.with_values(&drawn, mechanism.home())?;
    let samples = simulate(mechanism, truth.as_ref(), poses, &convention, noise, rng).map_err(|(_, cause)| cause)?;
    let found = calibrate(mechanism, &as_dataset(&samples, &convention, noise))?;
    Ok(found.x.iter().zip(&drawn).map(|(found, drawn)| (found - drawn).abs()).fold(0.0, f64::max))
}

fn timed<T>(f: impl FnOnce() -> T) -> (Duration, T) {
    let start = Instant::now();
    let value = f();
    (start.elapsed(), value)
}

fn main() -> Result<(), Box<dyn Error>> {
    let machine = Machine::read(MECHANISM)?;
    let mechanism = machine.mechanism.as_ref();
    let data = read_measurement(DATA, &machine)?.data;
    let (r, j) = system(mechanism, &data)?;
    let found = calibrate(mechanism, &data)?;
    println!("{} rows, {} unknowns, {} steps: {:?}", j.nrows(), j.ncols(), found.history.len(), found.convergence);

    let calibration = || calibrate(mechanism, &data);
    let decomposition = || solve_by_svd(&j, &r);
    let brief = Criterion::default().warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
    let mut criterion = brief.configure_from_args();
    let mut group = criterion.benchmark_group("identify, 20 poses");
    group.bench_function("calibration", |b| b.iter(calibration));
    group.bench_function("one SVD", |b| b.iter(decomposition));
    group.finish();
    // Without this argument criterion only checks that everything runs.
    if std::env::args().any(|a| a == "--bench") {
        let (a, b, median) = interleaved(BATCHES, 1, calibration, decomposition);
        let (a, b) = (1e6 * a.as_secs_f64(), 1e6 * b.as_secs_f64());
        println!(
            "identification, interleaved: calibration {a:.0} us, one SVD {b:.0} us; ratio {:.2} of the minima, \
             {median:.2} in the median (at most {ALLOWED} wanted)",
            a / b
        );
        let (identifier, options) = (LevenbergMarquardt::default(), CalibrationOptions::default());
        let workspace = machine.workspace.as_ref();
        let whole = || calibrate_whole(mechanism, &data, workspace, &identifier, &options);
        for (threads, pool) in [
            (1, ThreadPoolBuilder::new().num_threads(1).build()?),
            (2, ThreadPoolBuilder::new().num_threads(2).build()?),
        ] {
            let (a, b, median) = pool.install(|| interleaved(BATCHES, 1, whole, decomposition));
            println!(
                "the whole calibration with five folds, {threads} threads: {:.0} us; over one SVD {:.2} of the minima, {median:.2} in the median",
                1e6 * a.as_secs_f64(),
                a.as_secs_f64() / b.as_secs_f64()
            );
        }
        threads(&machine, minimum(&decomposition))?;
    }
    criterion.final_summary();
    Ok(())
}

/// The shortest of many times.
fn minimum<T>(f: &impl Fn() -> T) -> Duration {
    (0..BATCHES).map(|_| timed(|| black_box(f())).0).min().unwrap_or_default()
}

/// Arithmetic without memory, about as long as a calibration: what the machine itself gains by a second thread
/// while others use it too.
fn arithmetic(k: u64) -> f64 {
    (0..100_000).fold(k as f64, |x, _| black_box(x) * 0.999 + 1.0)
}

/// Time on one thread and on two, and whether both gave the same.
fn one_and_two<T: Send + PartialEq>(
    one: &ThreadPool,
    two: &ThreadPool,
    draw: impl Fn(u64, &mut ChaCha8Rng) -> T + Sync,
) -> (Duration, Duration, bool) {
    let run = |pool: &ThreadPool| timed(|| pool.install(|| monte_carlo(DRAWS, 0, &draw)));
    let ((serial, alone), (parallel, shared)) = (run(one), run(two));
    (serial, parallel, alone == shared)
}

/// Prints how much faster two threads are than one.
fn threads(machine: &Machine, svd: Duration) -> Result<(), Box<dyn Error>> {
    let mechanism = machine.mechanism.as_ref();
    let workspace = machine.workspace.ok_or("the mechanism states no workspace")?;
    let noise = machine.noise.ok_or("the mechanism states no noise")?;
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let poses: Vec<Pose> = (0..20).map(|_| workspace.random(&mut rng)).collect();
    let draw =
        |_, rng: &mut ChaCha8Rng| simulated_calibration(mechanism, &poses, &noise, rng).map_err(|e| e.to_string());
    let (one, two) =
        (ThreadPoolBuilder::new().num_threads(1).build()?, ThreadPoolBuilder::new().num_threads(2).build()?);
    let failed = two.install(|| monte_carlo(DRAWS, 0, draw)).iter().filter(|r| r.is_err()).count();
    let mut best = [Duration::MAX; 4];
    for _ in 0..TURNS {
        let (serial, parallel, same) = one_and_two(&one, &two, draw);
        if !same {
            return Err("results depend on the number of threads".into());
        }
        let (alone, shared, _) = one_and_two(&one, &two, |k, _| arithmetic(k));
        best = std::array::from_fn(|k| best[k].min([serial, parallel, alone, shared][k]));
    }
    let [slow, fast, alone, shared] = best.map(|d| d.as_secs_f64());
    println!(
        "{DRAWS} simulated calibrations ({failed} without a result): {:.0} ms on one thread, {:.2} SVDs each; {:.0} ms on two; \
         speed-up {:.2} (at least {WANTED_SPEED_UP} wanted; arithmetic alone gains {:.2})",
        1e3 * slow,
        slow / DRAWS as f64 / svd.as_secs_f64(),
        1e3 * fast,
        slow / fast,
        alone / shared
    );
    Ok(())
}
