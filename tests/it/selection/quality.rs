//! How good chosen sets are: certified efficiency, the worth of corners, and a bound that nothing passes.

use crate::common::{machine, paper_noise, workspace};
use nalgebra::{DMatrix, Matrix6, Matrix6xX};
use paracal::observability::{Block, Goal, O1, O3, O5, ObservabilityIndex, Pool, PoseError, PoseSet, Scaling};
use paracal::rand::rngs::ChaCha8Rng;
use paracal::rand::seq::index::sample;
use paracal::rand::{RngExt, SeedableRng};
use paracal::selection::{
    Campaign, Candidates, ChosenSet, Exchange, Forecaster, Objective, SelectionTask, Sources, relax, select,
    select_among,
};
use rayon::prelude::*;

const BOXES: [(f64, f64); 2] = [(10.0, 1.0), (100.0, 10.0)];

fn chosen(box_: (f64, f64), n: usize, corners: bool, polish: bool) -> ChosenSet {
    let machine = machine("table5");
    let mechanism = machine.mechanism.as_ref();
    let campaign = Campaign::new(mechanism, &workspace(mechanism, box_.0, box_.1), None, Scaling::Paper).unwrap();
    let plan = SelectionTask {
        campaign: &campaign,
        forecaster: None,
        aim: Objective::Index(&O1),
        given: &[],
        seed: 0,
        watch: &|_| {},
    };
    let sources = Sources { random: 2000, corners_and_grid: corners, ..Sources::default() };
    select(&plan, &Exchange { polish, ..Exchange::default() }, &sources, n).unwrap()
}

#[test]
fn sets_from_a_random_list_have_the_certified_efficiency() {
    for box_ in BOXES {
        for (n, wanted) in [(20, 0.969), (30, 0.988), (40, 0.986)] {
            let report = chosen(box_, n, false, false);
            let efficiency = report.efficiency.unwrap();
            assert!(efficiency >= wanted && efficiency <= 1.0, "{box_:?}, {n} poses: {efficiency}");
        }
    }
}

#[test]
fn efficiency_never_passes_one_however_many_poses() {
    // More poses than corners worth measuring: polished poses must not become repetitions.
    for (n, corners, least) in [(45, true, 0.95), (60, true, 0.95), (60, false, 0.95), (7, true, 0.05)] {
        let report = chosen((100.0, 10.0), n, corners, true);
        let efficiency = report.efficiency.unwrap();
        // Seven whole poses have as many rows as parameters; the bound, which may take parts of poses, is far off.
        assert!(efficiency > least && efficiency <= 1.0, "{n} poses: {efficiency}");
    }
}

#[test]
fn corners_are_worth_a_third_and_more() {
    for (box_, wanted) in BOXES.into_iter().zip([1.3, 1.6]) {
        let (list, corners) = (chosen(box_, 20, false, false), chosen(box_, 20, true, false));
        assert!(corners.value >= wanted * list.value, "{box_:?}: {:e} and {:e}", corners.value, list.value);
    }
}

#[test]
fn polishing_gains_and_is_certified_with_the_polished_poses() {
    for box_ in BOXES {
        let (list, polished) = (chosen(box_, 20, false, false), chosen(box_, 20, false, true));
        assert!(polished.value >= 1.25 * list.value, "{box_:?}: {:e} and {:e}", polished.value, list.value);
        assert!(polished.bound.unwrap() > list.bound.unwrap(), "the bound must know the polished poses");
        assert!(polished.efficiency.unwrap() <= 1.0);
        let corners = chosen(box_, 20, true, true);
        assert!(corners.efficiency.unwrap() <= 1.0 && corners.efficiency.unwrap() > 0.96);
    }
}

/// Pools of random blocks, six legs or dense, of any condition.
fn random_pool(seed: u64, len: usize, parameters: usize) -> Pool {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let scales: Vec<f64> = (0..parameters).map(|_| 10_f64.powf(rng.random_range(-2.0..2.0))).collect();
    let blocks: Vec<Block> = (0..len)
        .map(|_| {
            let mut derivatives = Matrix6xX::from_fn(parameters, |_, _| rng.random_range(-1.0..1.0));
            for (mut column, s) in derivatives.column_iter_mut().zip(&scales) {
                column.scale_mut(*s);
            }
            Block { noise: Matrix6::identity(), derivatives }
        })
        .collect();
    Pool::new(len, |k| blocks[k].clone()).unwrap()
}

/// Indices with a bound, for a pool.
fn bounded(pool: &Pool, prior: bool) -> Vec<Box<dyn ObservabilityIndex>> {
    let target = DMatrix::from_fn(6, pool.visible().nrows(), |r, c| ((3 * r + 7 * c) % 11) as f64 - 5.0);
    vec![Box::new(O1), Box::new(O3), Box::new(O5), Box::new(PoseError::new(&[target], pool.visible(), prior))]
}

fn beyond(goal: Goal, value: f64, bound: f64) -> bool {
    match goal {
        Goal::Largest => value > bound,
        Goal::Smallest => value < bound,
    }
}

fn rows_of(pool: &Pool, given: &[DMatrix<f64>], prior: bool) -> DMatrix<f64> {
    let n = pool.directions();
    let mut fixed = DMatrix::zeros(6 * given.len() + if prior { n } else { 0 }, n);
    for (k, rows) in given.iter().enumerate() {
        fixed.rows_mut(6 * k, 6).copy_from(rows);
    }
    if prior {
        fixed.rows_mut(6 * given.len(), n).fill_with_identity();
    }
    fixed
}

#[test]
fn no_set_of_a_small_list_passes_the_bound_and_the_best_comes_near() {
    for seed in 0..6 {
        let (len, n) = (13, 8);
        let pool = random_pool(seed, len, 18);
        // With and without poses that are measured anyway, with and without a prior.
        let given: Vec<DMatrix<f64>> = if seed % 2 == 0 { Vec::new() } else { vec![pool.rows(0), pool.rows(1)] };
        for index in bounded(&pool, seed % 3 == 0) {
            let fixed = rows_of(&pool, &given, index.prior());
            let bound = relax(&pool, index.as_ref(), &fixed, given.len(), n).unwrap().bound;
            let all: Vec<f64> = (0_u32..1 << len)
                .filter(|bits| bits.count_ones() == n as u32)
                .map(|bits| (0..len).filter(|k| bits >> k & 1 == 1).collect::<Vec<_>>())
                .map(|members| PoseSet::new(&pool, index.as_ref(), &given, &members).value())
                .collect();
            assert_eq!(all.len(), 1287);
            let best = all.iter().copied().reduce(|a, b| if beyond(index.goal(), a, b) { a } else { b }).unwrap();
            assert!(!beyond(index.goal(), best, bound), "{}: {best:e} passes {bound:e}", index.name());
            let efficiency = if index.goal() == Goal::Largest { best / bound } else { bound / best };
            assert!(efficiency > 0.7, "{}: the best of all sets has {efficiency:.3} of the bound", index.name());
        }
    }
}

#[test]
fn the_true_best_of_a_small_list_is_found() {
    let machine = machine("table5");
    let mechanism = machine.mechanism.as_ref();
    let campaign =
        Campaign::new(mechanism, &workspace(mechanism, 30.0, 3.0), Some(&paper_noise()), Scaling::Whitened).unwrap();
    let candidates = Candidates::collect(&campaign, &Sources { random: 13, seed: 2, ..Sources::default() }).unwrap();
    let forecaster = Forecaster::new(campaign.clone(), &[]).unwrap();
    let aims = [Objective::Index(&O1 as &dyn ObservabilityIndex), Objective::Index(&O3), Objective::Index(&O5)];
    // With seven poses every set without one of its members determines nothing, which makes exchanges hard.
    for (aim, n) in aims.into_iter().flat_map(|aim| [(aim, 7), (aim, 9)]) {
        let plan = SelectionTask {
            campaign: &campaign,
            forecaster: Some(&forecaster),
            aim,
            given: &[],
            seed: 1,
            watch: &|_| {},
        };
        let found =
            select_among(&plan, &Exchange { polish: false, ..Exchange::default() }, &candidates, n, true).unwrap();
        let Objective::Index(index) = aim else { unreachable!() };
        let best = (0_u32..1 << 13)
            .into_par_iter()
            .filter(|bits| bits.count_ones() as usize == n)
            .map(|bits| {
                let members: Vec<usize> = (0..13).filter(|k| bits >> k & 1 == 1).collect();
                PoseSet::new(&candidates.pool, index, &[], &members).value()
            })
            .reduce(|| 0.0, f64::max);
        let least = if n == 7 { 0.95 * best } else { best * (1.0 - 1e-9) };
        assert!(found.value >= least, "{} of {n}: {:e}, best {best:e}", index.name(), found.value);
        assert!(found.bound.unwrap() >= best);
    }
}

#[test]
fn thousands_of_random_sets_stay_below_the_bound() {
    let machine = machine("table5");
    let mechanism = machine.mechanism.as_ref();
    for (mm, degrees, scaling) in [(100.0, 10.0, Scaling::Paper), (10.0, 1.0, Scaling::Whitened)] {
        let box_ = workspace(mechanism, mm, degrees);
        let campaign = Campaign::new(mechanism, &box_, Some(&paper_noise()), scaling).unwrap();
        let sources = Sources { random: 100, corners_and_grid: true, ..Sources::default() };
        let candidates = Candidates::collect(&campaign, &sources).unwrap();
        let pool = &candidates.pool;
        for index in bounded(pool, scaling == Scaling::Whitened) {
            for n in [9, 20, 35] {
                let fixed = rows_of(pool, &[], index.prior());
                let bound = relax(pool, index.as_ref(), &fixed, 0, n).unwrap().bound;
                let passing = (0..400_u64)
                    .into_par_iter()
                    .filter(|seed| {
                        let mut rng = ChaCha8Rng::seed_from_u64(*seed);
                        // Half of them from the corners, which come first and are the best candidates.
                        let of = if seed % 2 == 0 { 64 } else { pool.len() };
                        let members = sample(&mut rng, of, n).into_vec();
                        beyond(index.goal(), PoseSet::new(pool, index.as_ref(), &[], &members).value(), bound)
                    })
                    .count();
                assert_eq!(passing, 0, "{} of sets of {n} in ±{mm} mm", index.name());
            }
        }
    }
}
