//! One diagnosis against one singular value decomposition.
//!
//! The diagnosis is of 120 poses with every covariate that the catalogue asks for: the conditions of the reference campaign,
//! a machine with the errors of its manufacture, and either nothing else or one effect that has to be found. The yardstick
//! is that of `identify`: a single linear solve by SVD of 120 rows and 42 unknowns, the system of the first 20 of these
//! poses. Behind that the same campaign with more poses says how the time of a diagnosis grows with them.

use std::error::Error;
use std::sync::Arc;
use std::time::{Duration, Instant};

use criterion::Criterion;
use nalgebra::{DMatrix, DVector};
use paracal::diagnosis::{Diagnosis, Question, diagnose};
use paracal::effect::{Extended, effects_of};
use paracal::files::Machine;
use paracal::identification::{CalibrationProblem, Task};
use paracal::measurement::{Dataset, PoseMeasurement, PoseReading};
use paracal::mechanism::Mechanism;
use paracal::pose::Pose;
use paracal::simulation::{Command, draw_parameters, simulate_run};
use paracal::solve::LeastSquaresProblem;
use paracal_benches::interleaved;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

const MECHANISM: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../mechanisms/table5.toml"));
/// What the effects of loads and screws need to know.
const FURTHER: &str = "\n[platform]\nmass_kg = 500.0\ncentre_of_mass = [0.0, 0.0, 150.0]\npayload_centre = [0.0, 0.0, 300.0]\n\
                       [actuator]\nscrew_pitch = 5.0\n";
/// About five times its detection limit.
const EFFECT: &str = "\n[[effect]]\nname = \"thermal.legs.individual\"\nparameters = { expansion = 1e-6 }\n";
const POSES: usize = 120;
/// Half-ranges of the poses, m and degrees.
const HALF: (f64, f64) = (0.01, 0.5);
/// 1σ of the drawn parameters, m.
const ERROR: f64 = 0.5e-3;
/// Alternations of the ratio.
const BATCHES: usize = 30;
/// SVDs for each diagnosis.
const PASSES: usize = 50;
/// What a diagnosis may cost, in units of the SVD, where there is nothing to find and where there is one effect.
const ALLOWED: [f64; 2] = [90.0, 150.0];
/// Poses of the campaigns that are compared for growth, and the turns, of which the fastest counts.
const SIZES: [(usize, usize); 4] = [(120, 12), (500, 6), (2000, 6), (10_000, 6)];
/// Power of the number of poses with which the time may grow.
const SLOPE: f64 = 1.1;

/// A measured campaign of a machine whose file may state effects.
fn campaign(machine: &mut Machine, count: usize) -> Result<Dataset, Box<dyn Error>> {
    let mut workspace = machine.workspace.ok_or("the mechanism states no workspace")?;
    let noise = machine.noise.ok_or("the mechanism states no noise")?;
    workspace.half = std::array::from_fn(|k| if k < 3 { HALF.0 } else { HALF.1.to_radians() });
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let poses: Vec<Pose> = (0..count).map(|_| workspace.random(&mut rng)).collect();
    let states = machine.reference_conditions(count);
    machine.refer_to(states.iter(), "the campaign");
    let nominal = machine.plain();
    let true_values = draw_parameters(nominal, Some(ERROR), &mut rng);
    let moving = effects_of(machine.mechanism.as_ref()).to_vec();
    let inner = nominal.with_values(&true_values, nominal.home())?;
    let truth = Extended::new(inner, Arc::clone(machine.environment()), moving);
    let run: Vec<Command> = poses.iter().zip(&states).map(|(p, s)| Command { pose: *p, state: s.clone() }).collect();
    let went = simulate_run(nominal, &truth, &run, None, &machine.convention, &noise, &mut rng);
    let went = went.map_err(|(_, cause)| cause)?;
    let sigma = std::array::from_fn(|k| if k < 3 { noise.position } else { noise.rotation });
    let readings = went.iter().map(|s| PoseReading { values: s.measured, measured: [true; 6], sigma }).collect();
    let samples = machine.planned_samples(&poses, &states).map_err(|(_, cause)| cause)?;
    Ok(Dataset::new(samples, Arc::new(PoseMeasurement::new(machine.convention, readings)), noise))
}

/// Residual and whitened Jacobian at the start.
fn system(mechanism: &dyn Mechanism, data: &Dataset) -> Result<(DVector<f64>, DMatrix<f64>), Box<dyn Error>> {
    let mut problem = CalibrationProblem::new(&Task::new(mechanism, data))?;
    let ((m, n), start) = (problem.shape(), problem.start());
    let (mut r, mut j) = (DVector::zeros(m), DMatrix::zeros(m, n));
    problem.linearize(&start, &mut r, &mut j)?;
    Ok((r, j))
}

fn machine_with(effect: &str) -> Result<Machine, Box<dyn Error>> {
    Ok(Machine::from_text(&format!("{MECHANISM}{FURTHER}{effect}"), "table5.toml".as_ref())?)
}

/// How the time grows from the smallest campaign to the largest: the slope of its logarithm over that of the poses.
fn growth(effect: &str) -> Result<String, Box<dyn Error>> {
    let mut points: Vec<(f64, f64)> = Vec::new();
    let mut times = Vec::new();
    for (count, turns) in SIZES {
        let mut machine = machine_with(effect)?;
        let data = campaign(&mut machine, count)?;
        let question = Question::of(&machine, &data);
        let mut fastest = f64::INFINITY;
        for _ in 0..turns {
            let start = Instant::now();
            diagnose(&question)?;
            fastest = fastest.min(start.elapsed().as_secs_f64());
        }
        points.push(((count as f64).ln(), fastest.ln()));
        times.push(format!("{count} poses {:.0} ms", 1e3 * fastest));
    }
    let (first, last) = (points[0], points[points.len() - 1]);
    let slope = (last.1 - first.1) / (last.0 - first.0);
    Ok(format!("{}: time grows with the power {slope:.2} of the poses (at most {SLOPE} wanted)", times.join(", ")))
}

fn shown(found: &Diagnosis) -> String {
    let names: Vec<&str> = found.causes.iter().map(|c| c.effect.as_str()).collect();
    format!("{} [{}]", found.verdict.word(), names.join(", "))
}

fn main() -> Result<(), Box<dyn Error>> {
    let brief = Criterion::default().warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
    let mut criterion = brief.sample_size(10).configure_from_args();
    let measured = std::env::args().any(|a| a == "--bench");
    for ((what, effect), allowed) in [("nothing to find", ""), ("one effect", EFFECT)].into_iter().zip(ALLOWED) {
        let mut machine = machine_with(effect)?;
        let data = campaign(&mut machine, POSES)?;
        let first: Vec<usize> = (0..20).collect();
        let (r, j) = system(machine.plain(), &data.subset(&first))?;
        let question = Question::of(&machine, &data);
        let found = diagnose(&question)?;
        println!("{what}: {} rows, {} effects: {}", 6 * data.len(), question.catalogue.len(), shown(&found));

        let diagnosis = || diagnose(&question);
        let decomposition = || j.clone().svd(true, true).solve(&r, 0.0);
        let mut group = criterion.benchmark_group(format!("diagnose, {POSES} poses, {what}"));
        group.bench_function("diagnosis", |b| b.iter(diagnosis));
        group.bench_function("one SVD", |b| b.iter(decomposition));
        group.finish();
        // Without this argument criterion only checks that everything runs.
        if measured {
            let many = || (0..PASSES).map(|_| decomposition().is_ok()).filter(|ok| *ok).count();
            let (a, b, median) = interleaved(BATCHES, 1, diagnosis, many);
            let (a, b) = (1e3 * a.as_secs_f64(), 1e3 * b.as_secs_f64() / PASSES as f64);
            println!(
                "{what}, interleaved: diagnosis {a:.1} ms, one SVD {:.0} us; ratio {:.0} of the minima, {:.0} in the \
                 median (at most {allowed} wanted)",
                1e3 * b,
                a / b,
                median * PASSES as f64
            );
            println!("{what}: {}", growth(effect)?);
        }
    }
    criterion.final_summary();
    Ok(())
}
