//! Table 1 and section 5 of the paper: values of the indices for chosen and for random sets. The truth is an independent
//! reproduction of the paper (±100 mm, ±10°, mm and rad, Table 5); its spread from one list of candidates to the next
//! is 2 % for O1.

use crate::common::{machine, workspace};
use paracal::files::Machine;
use paracal::observability::{O1, O2, O3, O4, O5, ObservabilityIndex, Scaling};
use paracal::rand::SeedableRng;
use paracal::rand::rngs::ChaCha8Rng;
use paracal::rand::seq::index::sample;
use paracal::selection::{Campaign, Candidates, Detmax, PoseSelector, Problem, Sources, TabuDetmax};
use rayon::prelude::*;

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Chosen values over lists of candidates, and the iterations it took.
fn chosen(
    machine: &Machine,
    index: &dyn ObservabilityIndex,
    selector: &dyn PoseSelector,
    n: usize,
    random: usize,
    lists: u64,
) -> (Vec<f64>, Vec<usize>) {
    let mechanism = machine.mechanism.as_ref();
    let campaign = Campaign::new(mechanism, &workspace(mechanism, 100.0, 10.0), None, Scaling::Paper).unwrap();
    (0..lists)
        .into_par_iter()
        .map(|seed| {
            let candidates = Candidates::collect(&campaign, &Sources { random, seed, ..Sources::default() }).unwrap();
            assert_eq!(candidates.len(), random);
            let (campaign, candidates) = (&campaign, &candidates);
            let problem = Problem { campaign, candidates, index, given: &[], count: n, seed, watch: &|_| {} };
            let choice = selector.select(&problem).unwrap();
            assert_eq!(choice.poses.len(), n);
            (problem.value_of(&choice.poses), choice.iterations)
        })
        .unzip()
}

#[test]
fn random_sets_are_as_the_paper_says() {
    let machine = machine("table5");
    let mechanism = machine.mechanism.as_ref();
    let campaign = Campaign::new(mechanism, &workspace(mechanism, 100.0, 10.0), None, Scaling::Paper).unwrap();
    let sources = Sources { random: 2000, seed: 0, ..Sources::default() };
    let candidates = Candidates::collect(&campaign, &sources).unwrap();
    let problem = Problem {
        campaign: &campaign,
        candidates: &candidates,
        index: &O1,
        given: &[],
        count: 20,
        seed: 0,
        watch: &|_| {},
    };
    let values: Vec<f64> = (0..1000)
        .into_par_iter()
        .map(|seed| problem.set(&sample(&mut ChaCha8Rng::seed_from_u64(seed), 2000, 20).into_vec()).value())
        .collect();
    let best = values.iter().copied().fold(0.0, f64::max);
    // The paper: 0.01713 and 0.02199.
    assert!((mean(&values) - 0.0172).abs() <= 0.0003, "mean {}", mean(&values));
    assert!((best - 0.0218).abs() <= 0.0008, "best {best}");
}

#[test]
fn tabu_detmax_reaches_the_paper() {
    let machine = machine("table5");
    let tabu = TabuDetmax::default();
    let from_2000 = chosen(&machine, &O1, &tabu, 20, 2000, 8).0;
    assert!(from_2000.iter().all(|v| (0.0334..0.0372).contains(v)), "{from_2000:?}");
    assert!((mean(&from_2000) - 0.0349).abs() <= 0.0010, "{from_2000:?}");
    let from_3000 = chosen(&machine, &O1, &tabu, 20, 3000, 6).0;
    assert!((mean(&from_3000) - 0.0359).abs() <= 0.0006, "{from_3000:?}");
    // O1 does not grow with n as the others do; the paper: 0.0357, 0.0361, 0.0362.
    let (thirty, forty) = (chosen(&machine, &O1, &tabu, 30, 2000, 4).0, chosen(&machine, &O1, &tabu, 40, 2000, 4).0);
    let twenty = &from_2000[..4];
    assert!(mean(&thirty) > mean(twenty) && mean(&thirty) < 1.04 * mean(twenty), "{thirty:?}");
    assert!(mean(&forty) > mean(twenty) && mean(&forty) < 1.05 * mean(twenty), "{forty:?}");
}

#[test]
fn other_indices_reach_the_paper_for_20_30_and_40_poses() {
    let machine = machine("table5");
    // Values of the reproduction with their tolerance; a better search may pass them by another such step.
    let cases: [(&dyn ObservabilityIndex, [f64; 3], f64); 4] = [
        (&O2, [2.45e-4, 2.457e-4, 2.457e-4], 0.015),
        (&O3, [1.394e-3, 1.708e-3, 1.972e-3], 0.003),
        (&O4, [3.39e-7, 4.15e-7, 4.79e-7], 0.02),
        (&O5, [4.31e-4, 5.36e-4, 6.20e-4], 0.02),
    ];
    let tabu = TabuDetmax { iterations: 200, ..TabuDetmax::default() };
    for (index, expected, tolerance) in cases {
        for (n, expected) in [20, 30, 40].into_iter().zip(expected) {
            let found = mean(&chosen(&machine, index, &tabu, n, 2000, 2).0);
            let ratio = found / expected;
            assert!((ratio - 1.0).abs() <= tolerance, "{} for {n} poses: {found:e}, {expected:e}", index.name());
        }
    }
}

#[test]
fn detmax_stops_after_about_twenty_iterations_and_tabu_finds_more() {
    let machine = machine("table5");
    let (plain, iterations) = chosen(&machine, &O1, &Detmax::default(), 20, 2000, 8);
    let tabu = chosen(&machine, &O1, &TabuDetmax::default(), 20, 2000, 8).0;
    // The paper: 21 iterations, and 1.4 % more with the list.
    assert!(iterations.iter().all(|i| (12..45).contains(i)), "{iterations:?}");
    let gain = mean(&tabu) / mean(&plain) - 1.0;
    assert!(gain > 0.002 && gain < 0.03, "{gain}");
}
