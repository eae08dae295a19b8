//! Pose selection against singular value decompositions, against a matrix product, and on two threads.
//!
//! The yardstick of an iteration is what a script does: the singular values of the stacked rows, once for every
//! candidate that could be added and once for every member that could be removed. The yardstick of the scan is a
//! matrix product of the fastest library at hand, which does nothing but multiply and add. All ratios are taken in one
//! run that alternates between their sides, because single timings on a shared machine differ by more than they do.

use std::error::Error;
use std::hint::black_box;
use std::process::Command;
use std::time::{Duration, Instant};

use criterion::Criterion;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use nalgebra::{DMatrix, Matrix6, Matrix6xX};
use paracal::files::Machine;
use paracal::mechanism::Workspace;
use paracal::observability::{Block, INDICES, O1, ObservabilityIndex, Pool, PoseSet, Scaling, Spectrum, index};
use paracal::selection::{
    Campaign, Candidates, Choice, Exchange, Forecaster, PoseSelector, Problem, SelectionError, Sources, TabuDetmax,
    relax,
};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

const MECHANISM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../mechanisms/table5.toml");
/// Poses to choose, and candidates to choose from.
const POSES: usize = 20;
const CANDIDATES: usize = 2000;
/// Half-ranges of the two boxes, m and degrees.
const BOXES: [(&str, f64, f64); 2] = [("100 mm, 10 deg", 0.1, 10.0), ("10 mm, 1 deg", 0.01, 1.0)];
/// Speed of an iteration over decompositions that is wanted of each of `INDICES`.
const WANTED: [f64; 6] = [4000.0, 50.0, 150.0, 50.0, 50.0, 0.0];
/// Iterations of one run of the tabu search: about as long for every index.
const ITERATIONS: [usize; 6] = [400, 40, 80, 40, 40, 200];
/// Alternations between runs of all indices, and decompositions in each.
const TURNS: usize = 9;
const DECOMPOSITIONS: usize = 40;
/// Operations that one candidate costs O1: 1050 fused multiply-adds for the blocks of the legs, the rest to factor.
const OPERATIONS: f64 = 2217.0;
/// Side of the square matrices of the product.
const SIDE: usize = 256;
/// Alternations between a few scans and one product.
const PRODUCTS: usize = 400;
const SCANS: usize = 8;
/// Alternations between runs of the search or of the bound and as many scans.
const SEARCHES: usize = 15;
const WANTED_OF_PRODUCT: f64 = 0.6;
const ALLOWED_OVER_SCAN: f64 = 1.6;
/// What the bound may cost, in scans, and how tight it is then.
const ALLOWED_SCANS: f64 = 5000.0;
const ALLOWED_GAP: f64 = 1e-5;
/// Candidates of the threads, and how often each number of threads has its turn.
const MANY: usize = 100_000;
const SPREADS: usize = 60;
const WANTED_SPEED_UP: f64 = 1.7;
/// Speed of the screened exchange over the unscreened one.
const WANTED_OF_SCREENING: f64 = 8.0;
/// The largest problem, MiB that it may use, and the argument with which this program does nothing else.
const MILLION: usize = 1_000_000;
const ALLOWED_MEMORY: f64 = 1024.0;
const ALONE: &str = "--million";

/// Times of what was alternated: seconds of each side in each turn.
struct Times(Vec<Vec<f64>>);

impl Times {
    fn alternating(turns: usize, sides: &mut [&mut dyn FnMut()]) -> Self {
        let mut times = vec![Vec::with_capacity(turns); sides.len()];
        for _ in 0..turns {
            for (side, times) in sides.iter_mut().zip(&mut times) {
                let start = Instant::now();
                side();
                times.push(start.elapsed().as_secs_f64());
            }
        }
        Self(times)
    }

    fn shortest(&self, side: usize) -> f64 {
        self.0[side].iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Median over the turns of the first side over the second.
    fn ratio(&self, a: usize, b: usize) -> f64 {
        let mut ratios: Vec<f64> = self.0[a].iter().zip(&self.0[b]).map(|(a, b)| a / b).collect();
        ratios.sort_by(f64::total_cmp);
        ratios[ratios.len() / 2]
    }
}

enum Bar {
    AtLeast(f64),
    AtMost(f64),
    None,
}

/// Prints a figure beside what is wanted of it.
fn report(what: &str, value: f64, bar: &Bar) {
    let (wanted, met) = match bar {
        Bar::AtLeast(least) => (format!(" (at least {least} wanted)"), value >= *least),
        Bar::AtMost(most) => (format!(" (at most {most} wanted)"), value <= *most),
        Bar::None => (String::new(), true),
    };
    let digits = if value.abs() < 100.0 { 2 } else { 0 };
    println!("{what}: {value:.digits$}{wanted}{}", if met { "" } else { " MISSED" });
}

/// A box of these half-ranges about home.
fn boxed(workspace: &Workspace, position: f64, degrees: f64) -> Workspace {
    let turn = degrees.to_radians();
    Workspace { half: [position, position, position, turn, turn, turn], ..*workspace }
}

fn random(campaign: &Campaign<'_>, count: usize) -> Result<Candidates, SelectionError> {
    Candidates::collect(campaign, &Sources { random: count, seed: 1, ..Sources::default() })
}

fn problem<'a>(
    campaign: &'a Campaign<'a>,
    candidates: &'a Candidates,
    index: &'a dyn ObservabilityIndex,
) -> Problem<'a> {
    Problem { campaign, candidates, index, given: &[], count: POSES, seed: 1, watch: &|_| () }
}

/// The decomposition that a script does for each candidate, by either library.
struct Naive {
    rows: DMatrix<f64>,
    faer: Mat<f64>,
}

impl Naive {
    /// Rows of twenty poses and of one candidate more.
    fn new(pool: &Pool) -> Self {
        let members: Vec<usize> = (0..=POSES).collect();
        let rows = PoseSet::new(pool, &O1, &[], &members).rows();
        let faer = Mat::from_fn(rows.nrows(), rows.ncols(), |i, j| rows[(i, j)]);
        Self { rows, faer }
    }

    fn by_nalgebra(&self) {
        touch(black_box(&self.rows).singular_values());
    }

    /// faer is built without threads.
    fn by_faer(&self) {
        touch(black_box(&self.faer).singular_values());
    }
}

/// Keeps a result from being optimised away.
fn touch<T>(value: T) {
    let _ = black_box(value);
}

fn threads(count: usize) -> Result<ThreadPool, Box<dyn Error>> {
    Ok(ThreadPoolBuilder::new().num_threads(count).build()?)
}

fn main() -> Result<(), Box<dyn Error>> {
    if std::env::args().any(|a| a == ALONE) {
        return million();
    }
    ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let machine = Machine::read(MECHANISM)?;
    let workspace = machine.workspace.ok_or("the mechanism states no workspace")?;
    let campaign = Campaign::new(machine.mechanism.as_ref(), &workspace, machine.noise.as_ref(), Scaling::Paper)?;
    let candidates = random(&campaign, CANDIDATES)?;
    let naive = Naive::new(&candidates.pool);
    let members: Vec<usize> = (0..POSES).collect();
    let mut set = PoseSet::new(&candidates.pool, &O1, &[], &members);

    let brief = Criterion::default().warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
    let mut criterion = brief.configure_from_args();
    let mut group = criterion.benchmark_group("select, 20 of 2000 poses");
    group.bench_function("scan for O1", |b| b.iter(|| set.best_addition()));
    group.bench_function("singular values of one set", |b| b.iter(|| naive.by_faer()));
    group.finish();
    // Without this argument criterion only checks that everything runs.
    if std::env::args().any(|a| a == "--bench") {
        for (name, position, degrees) in BOXES {
            iterations(&machine, name, &boxed(&workspace, position, degrees))?;
        }
        scan(&campaign, &candidates)?;
        bound(&candidates)?;
        let many = random(&campaign, MANY)?;
        spread(&many)?;
        screening(&campaign, &many)?;
        if !Command::new(std::env::current_exe()?).arg(ALONE).status()?.success() {
            return Err("the largest problem failed".into());
        }
    }
    criterion.final_summary();
    Ok(())
}

/// Iterations of the tabu search for all indices against decompositions.
fn iterations(machine: &Machine, name: &str, workspace: &Workspace) -> Result<(), Box<dyn Error>> {
    let campaign = |scaling| Campaign::new(machine.mechanism.as_ref(), workspace, machine.noise.as_ref(), scaling);
    let (paper, whitened) = (campaign(Scaling::Paper)?, campaign(Scaling::Whitened)?);
    let (candidates, weighted) = (random(&paper, CANDIDATES)?, random(&whitened, CANDIDATES)?);
    let naive = Naive::new(&candidates.pool);
    let forecaster = Forecaster::new(whitened.clone(), &[])?;
    let prior = forecaster.forecast(&weighted.poses[..POSES]).prior;
    let pose_error = forecaster.index(weighted.pool.visible(), prior);
    let own: Vec<_> = INDICES.iter().filter_map(|name| index(name)).collect();
    let problems: Vec<Problem<'_>> = (own.iter().map(|index| problem(&paper, &candidates, index.as_ref())))
        .chain([problem(&whitened, &weighted, &pose_error)])
        .collect();
    for (problem, iterations) in problems.iter().zip(ITERATIONS) {
        let choice = TabuDetmax { iterations, ..TabuDetmax::default() }.select(problem)?;
        if choice.iterations != iterations {
            return Err("a search ended early".into());
        }
    }
    let mut by_nalgebra = || (0..DECOMPOSITIONS).for_each(|_| naive.by_nalgebra());
    let mut by_faer = || (0..DECOMPOSITIONS).for_each(|_| naive.by_faer());
    let search = |k: usize| {
        let (problem, iterations) = (&problems[k], ITERATIONS[k]);
        move || touch(TabuDetmax { iterations, ..TabuDetmax::default() }.select(problem))
    };
    let mut searches: Vec<_> = (0..problems.len()).map(search).collect();
    let mut sides: Vec<&mut dyn FnMut()> = vec![&mut by_nalgebra, &mut by_faer];
    sides.extend(searches.iter_mut().map(|s| s as &mut dyn FnMut()));
    let times = Times::alternating(TURNS, &mut sides);
    let faster = usize::from(times.shortest(1) < times.shortest(0));
    let each = |side: usize| 1e6 * times.shortest(side) / DECOMPOSITIONS as f64;
    println!("box of {name}: singular values of one set by nalgebra {:.0} us, by faer {:.0} us", each(0), each(1));
    for (k, index) in INDICES.iter().enumerate() {
        let per_set = (CANDIDATES + POSES + 1) as f64 / DECOMPOSITIONS as f64;
        let ratio = times.ratio(faster, k + 2) * per_set * ITERATIONS[k] as f64;
        let micro = 1e6 * times.shortest(k + 2) / ITERATIONS[k] as f64;
        let bar = if WANTED[k] > 0.0 { Bar::AtLeast(WANTED[k]) } else { Bar::None };
        report(&format!("box of {name}, {index}: iteration {micro:.0} us, decompositions over it"), ratio, &bar);
    }
    Ok(())
}

/// The scan for O1 against a matrix product, against blocks without structure, and against a whole iteration.
fn scan(campaign: &Campaign<'_>, candidates: &Candidates) -> Result<(), Box<dyn Error>> {
    let members: Vec<usize> = (0..POSES).collect();
    let pool = &candidates.pool;
    let full = |k: usize| {
        let rows = pool.rows(k);
        let derivatives = Matrix6xX::from_iterator(rows.ncols(), rows.iter().copied());
        Block { noise: Matrix6::identity(), derivatives }
    };
    let dense = Pool::new(pool.len(), full).ok_or("no candidates")?;
    if dense.has_legs() || !pool.has_legs() {
        return Err("the layouts are not those that are compared".into());
    }
    let mut set = PoseSet::new(pool, &O1, &[], &members);
    let mut unstructured = PoseSet::new(&dense, &O1, &[], &members);
    let (a, b) = (DMatrix::from_fn(SIDE, SIDE, |i, j| (i + 2 * j) as f64), DMatrix::from_element(SIDE, SIDE, 1.5));
    let mut c = DMatrix::zeros(SIDE, SIDE);
    let (fa, fb) = (Mat::from_fn(SIDE, SIDE, |i, j| a[(i, j)]), Mat::from_fn(SIDE, SIDE, |i, j| b[(i, j)]));
    let mut fc = Mat::zeros(SIDE, SIDE);

    let times = Times::alternating(
        PRODUCTS,
        &mut [
            &mut || (0..SCANS).for_each(|_| touch(set.best_addition())),
            &mut || black_box(&mut c).gemm(1.0, &a, &b, 0.0),
            &mut || matmul(black_box(&mut fc), Accum::Replace, &fa, &fb, 1.0, Par::Seq),
            &mut || touch(unstructured.best_addition()),
        ],
    );
    let scanned = SCANS as f64 * CANDIDATES as f64 * OPERATIONS;
    let multiplied = 2.0 * SIDE.pow(3) as f64;
    let faster = if times.shortest(1) < times.shortest(2) { 1 } else { 2 };
    println!(
        "scan for O1: {:.0} us, {:.1} Gflop/s; product by matrixmultiply {:.1}, by faer {:.1} Gflop/s{}",
        1e6 * times.shortest(0) / SCANS as f64,
        1e-9 * scanned / times.shortest(0),
        1e-9 * multiplied / times.shortest(1),
        1e-9 * multiplied / times.shortest(2),
        if wide() { "" } else { "; no AVX-512 here" }
    );
    let rate = times.ratio(faster, 0) * scanned / multiplied;
    report("scan for O1, part of the rate of the faster product", rate, &Bar::AtLeast(WANTED_OF_PRODUCT));
    report("blocks without structure, over blocks of legs", times.ratio(3, 0) * SCANS as f64, &Bar::None);

    let iterations = ITERATIONS[0];
    let search = TabuDetmax { iterations, ..TabuDetmax::default() };
    let problem = problem(campaign, candidates, &O1);
    let times = Times::alternating(
        SEARCHES,
        &mut [&mut || touch(search.select(&problem)), &mut || (0..iterations).for_each(|_| touch(set.best_addition()))],
    );
    report("iteration for O1, over its scan", times.ratio(0, 1), &Bar::AtMost(ALLOWED_OVER_SCAN));
    Ok(())
}

/// The bound on O1 in units of a scan.
fn bound(candidates: &Candidates) -> Result<(), Box<dyn Error>> {
    let pool = &candidates.pool;
    let nothing = DMatrix::zeros(0, pool.directions());
    let found = relax(pool, &O1, &nothing, 0, POSES).ok_or("no bound")?;
    // The index of the shares themselves, which no bound can be below.
    let mut rows = DMatrix::zeros(6 * found.shares.len(), pool.directions());
    for (slot, (k, share)) in found.shares.iter().enumerate() {
        rows.rows_mut(6 * slot, 6).copy_from(&(pool.rows(*k) * share.sqrt()));
    }
    let gap = found.bound / O1.value(&Spectrum::of(&rows, POSES, false)) - 1.0;
    let members: Vec<usize> = (0..POSES).collect();
    let mut set = PoseSet::new(pool, &O1, &[], &members);
    let times = Times::alternating(
        SEARCHES,
        &mut [&mut || touch(relax(pool, &O1, &nothing, 0, POSES)), &mut || {
            (0..100 * SCANS).for_each(|_| touch(set.best_addition()));
        }],
    );
    let scans = times.ratio(0, 1) * (100 * SCANS) as f64;
    let milli = 1e3 * times.shortest(0);
    report(&format!("bound on O1 ({milli:.0} ms), over a scan"), scans, &Bar::AtMost(ALLOWED_SCANS));
    report("bound on O1 above the index of its shares, millionths", 1e6 * gap, &Bar::AtMost(1e6 * ALLOWED_GAP));
    Ok(())
}

/// Arithmetic without memory, about as long as a part of a scan: what the machine itself gains by a second thread
/// while others use it too.
fn arithmetic() {
    (0..64_u32).into_par_iter().for_each(|k| {
        black_box((0..50_000).fold(f64::from(k), |x, _| black_box(x) * 0.999 + 1.0));
    });
}

/// The scan for O1 on one thread and on two.
fn spread(candidates: &Candidates) -> Result<(), Box<dyn Error>> {
    let (one, two) = (threads(1)?, threads(2)?);
    let members: Vec<usize> = (0..POSES).collect();
    let new = || PoseSet::new(&candidates.pool, &O1, &[], &members);
    let (mut alone, mut shared) = (new(), new());
    if one.install(|| alone.best_addition()) != two.install(|| shared.best_addition()) {
        return Err("results depend on the number of threads".into());
    }
    let times = Times::alternating(
        SPREADS,
        &mut [
            &mut || touch(one.install(|| alone.best_addition())),
            &mut || touch(two.install(|| shared.best_addition())),
            &mut || one.install(arithmetic),
            &mut || two.install(arithmetic),
        ],
    );
    println!(
        "scan of {MANY} candidates: {:.2} ms on one thread, {:.2} ms on two; arithmetic alone gains {:.2}",
        1e3 * times.shortest(0),
        1e3 * times.shortest(1),
        times.shortest(2) / times.shortest(3)
    );
    let gain = times.shortest(0) / times.shortest(1);
    report("speed-up by a second thread", gain, &Bar::AtLeast(WANTED_SPEED_UP));
    Ok(())
}

/// The exchange for O1 among the most promising of many candidates against that among all of them, once each: the
/// second takes a minute.
fn screening(campaign: &Campaign<'_>, candidates: &Candidates) -> Result<(), Box<dyn Error>> {
    let problem = problem(campaign, candidates, &O1);
    let exchange = Exchange::default();
    let (mut screened, mut whole) = (None, None);
    let times = Times::alternating(
        1,
        &mut [&mut || screened = exchange.select(&problem).ok(), &mut || {
            whole = exchange.select_unscreened(&problem).ok();
        }],
    );
    let value = |choice: Option<Choice>| choice.map_or(f64::NAN, |choice| problem.value_of(&choice.poses));
    let change = value(screened) / value(whole) - 1.0;
    let nothing = DMatrix::zeros(0, candidates.pool.directions());
    let bound = Times::alternating(1, &mut [&mut || touch(relax(&candidates.pool, &O1, &nothing, 0, POSES))]);
    println!(
        "exchange from {MANY} candidates: {:.2} s screened, {:.1} s unscreened, index {:.1} millionths better; bound {:.2} s",
        times.shortest(0),
        times.shortest(1),
        1e6 * change,
        bound.shortest(0)
    );
    report("unscreened over screened", times.ratio(1, 0), &Bar::AtLeast(WANTED_OF_SCREENING));
    Ok(())
}

/// A search among a million candidates, in a process of its own so that its memory is its own.
fn million() -> Result<(), Box<dyn Error>> {
    let machine = Machine::read(MECHANISM)?;
    let workspace = machine.workspace.ok_or("the mechanism states no workspace")?;
    let campaign = Campaign::new(machine.mechanism.as_ref(), &workspace, machine.noise.as_ref(), Scaling::Paper)?;
    let start = Instant::now();
    let candidates = random(&campaign, MILLION)?;
    let collected = start.elapsed().as_secs_f64();
    let search = TabuDetmax { iterations: SCANS, ..TabuDetmax::default() };
    let problem = problem(&campaign, &candidates, &O1);
    let start = Instant::now();
    let choice = threads(1)?.install(|| search.select(&problem))?;
    let each = 1e3 * start.elapsed().as_secs_f64() / choice.iterations as f64;
    println!("{MILLION} candidates: collected in {collected:.1} s, {each:.0} ms per iteration on one thread");
    let start = Instant::now();
    Exchange::default().select(&problem)?;
    let seconds = start.elapsed().as_secs_f64();
    println!("{MILLION} candidates: exchange for O1 in {seconds:.1} s");
    let Some(memory) = peak_memory() else {
        println!("{MILLION} candidates: this system does not tell the peak memory");
        return Ok(());
    };
    report(&format!("{MILLION} candidates: peak memory, MiB"), memory, &Bar::AtMost(ALLOWED_MEMORY));
    Ok(())
}

/// The most memory that this process ever had resident, MiB; Linux alone tells.
fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok().map(|kib| kib / 1024.0)
}

/// Whether the instructions are there for which the part of the product is promised.
#[cfg(target_arch = "x86_64")]
fn wide() -> bool {
    std::is_x86_feature_detected!("avx512f")
}

#[cfg(not(target_arch = "x86_64"))]
fn wide() -> bool {
    false
}
