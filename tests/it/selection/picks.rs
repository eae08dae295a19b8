//! The pose that each fast scan picks, to add or to remove, against brute force: singular values of all stacked rows
//! for every candidate.

use crate::common::{machine, paper_noise, workspace};
use nalgebra::DMatrix;
use paracal::observability::{O1, O2, O3, O4, O5, ObservabilityIndex, PoseSet, Scaling, Spectrum};
use paracal::rand::SeedableRng;
use paracal::rand::rngs::ChaCha8Rng;
use paracal::rand::seq::index::sample;
use paracal::selection::{Campaign, Candidates, Forecaster, Sources};
use rayon::prelude::*;

const CANDIDATES: usize = 300;
const STATES: u64 = 50;
const POSES: usize = 20;
const BOXES: [(f64, f64); 3] = [(100.0, 10.0), (10.0, 1.0), (1.0, 0.1)];
/// Two candidates whose values differ by less are a tie.
const TIE: f64 = 1e-9;

fn candidates(campaign: &Campaign<'_>, seed: u64) -> Candidates {
    Candidates::collect(campaign, &Sources { random: CANDIDATES, seed, ..Sources::default() }).unwrap()
}

/// Rows of all candidates from their own blocks, not from the pool.
fn blocks(campaign: &Campaign<'_>, candidates: &Candidates) -> Vec<DMatrix<f64>> {
    candidates.poses.iter().map(|p| campaign.block(p).unwrap().rows().unwrap()).collect()
}

fn stacked<'a>(blocks: impl Iterator<Item = &'a DMatrix<f64>>) -> DMatrix<f64> {
    let blocks: Vec<&DMatrix<f64>> = blocks.collect();
    let mut rows = DMatrix::zeros(6 * blocks.len(), blocks[0].ncols());
    for (k, block) in blocks.iter().enumerate() {
        rows.rows_mut(6 * k, 6).copy_from(block);
    }
    rows
}

fn spectrum(blocks: &[DMatrix<f64>], members: &[usize]) -> Spectrum {
    let mut values: Vec<f64> = stacked(members.iter().map(|k| &blocks[*k])).singular_values().iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    Spectrum { values, directions: DMatrix::zeros(0, 0), poses: members.len() }
}

/// Counts ties; fails if the pick is worse than the best by more than rounding.
fn judge(what: &str, values: &[(usize, f64)], picked: usize, ties: &mut usize) {
    let best = values.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    if best.0 == picked {
        return;
    }
    let found = values.iter().find(|(k, _)| *k == picked).unwrap().1;
    assert!(
        (best.1 - found) <= TIE * best.1.abs(),
        "{what}: picked {picked} ({found:e}), best {} ({:e})",
        best.0,
        best.1
    );
    *ties += 1;
}

#[test]
fn picks_of_the_five_indices_equal_brute_force() {
    let machine = machine("table5");
    let mechanism = machine.mechanism.as_ref();
    let indices: [&dyn ObservabilityIndex; 5] = [&O1, &O2, &O3, &O4, &O5];
    for (mm, degrees) in BOXES {
        let box_ = workspace(mechanism, mm, degrees);
        let ties: usize = (0..STATES)
            .into_par_iter()
            .map(|state| {
                // Both scalings in turn: they differ by ten orders of magnitude in the condition.
                let scaling = if state % 2 == 0 { Scaling::Paper } else { Scaling::Whitened };
                let campaign = Campaign::new(mechanism, &box_, Some(&paper_noise()), scaling).unwrap();
                let candidates = candidates(&campaign, state);
                let blocks = blocks(&campaign, &candidates);
                let mut rng = ChaCha8Rng::seed_from_u64(state);
                let members = sample(&mut rng, CANDIDATES, POSES).into_vec();
                let with = |k: usize| {
                    let mut all = members.clone();
                    all.push(k);
                    spectrum(&blocks, &all)
                };
                let additions: Vec<(usize, Spectrum)> =
                    (0..CANDIDATES).filter(|k| !members.contains(k)).map(|k| (k, with(k))).collect();
                let without = |p: usize| {
                    let mut others = members.clone();
                    others.remove(p);
                    spectrum(&blocks, &others)
                };
                let removals: Vec<(usize, Spectrum)> = (0..POSES).map(|p| (p, without(p))).collect();
                let mut ties = 0;
                for index in indices {
                    let values = |list: &[(usize, Spectrum)]| -> Vec<(usize, f64)> {
                        list.iter().map(|(k, s)| (*k, index.value(s))).collect()
                    };
                    let mut set = PoseSet::new(&candidates.pool, index, &[], &members);
                    let what = format!("{} ±{mm} mm, {scaling:?}, state {state}", index.name());
                    let added = set.best_addition().unwrap().which;
                    judge(&format!("{what}, add"), &values(&additions), added, &mut ties);
                    let removed = set.best_removal().unwrap().which;
                    judge(&format!("{what}, remove"), &values(&removals), removed, &mut ties);
                }
                ties
            })
            .sum();
        assert!(ties <= 3, "±{mm} mm: {ties} near-ties in {} picks", 10 * STATES);
    }
}

#[test]
fn picks_for_the_predicted_error_equal_brute_force() {
    let machine = machine("table5");
    let mechanism = machine.mechanism.as_ref();
    for ((mm, degrees), prior) in BOXES.into_iter().zip([false, true, true]) {
        let box_ = workspace(mechanism, mm, degrees);
        let campaign = Campaign::new(mechanism, &box_, Some(&paper_noise()), Scaling::Whitened).unwrap();
        let candidates = candidates(&campaign, 7);
        let index = Forecaster::new(campaign.clone(), &[]).unwrap().index(candidates.pool.visible(), prior);
        let members: Vec<usize> = (0..POSES).collect();
        let mut set = PoseSet::new(&candidates.pool, &index, &[], &members);
        let value = |members: &[usize]| -PoseSet::new(&candidates.pool, &index, &[], members).value();
        let mut ties = 0;
        let all = |k: usize| members.iter().copied().chain([k]).collect::<Vec<_>>();
        let additions: Vec<(usize, f64)> = (POSES..CANDIDATES).map(|k| (k, value(&all(k)))).collect();
        judge(&format!("add ±{mm} mm"), &additions, set.best_addition().unwrap().which, &mut ties);
        let others = |p: usize| members.iter().copied().filter(|k| *k != p).collect::<Vec<_>>();
        let removals: Vec<(usize, f64)> = (0..POSES).map(|p| (p, value(&others(p)))).collect();
        judge(&format!("remove ±{mm} mm"), &removals, set.best_removal().unwrap().which, &mut ties);
        assert_eq!(ties, 0);
    }
}

#[test]
fn a_set_keeps_its_value_through_hundreds_of_updates() {
    let machine = machine("table5");
    let mechanism = machine.mechanism.as_ref();
    let box_ = workspace(mechanism, 10.0, 1.0);
    let campaign = Campaign::new(mechanism, &box_, None, Scaling::Paper).unwrap();
    let candidates = candidates(&campaign, 3);
    let mut set = PoseSet::new(&candidates.pool, &O1, &[], &(0..POSES).collect::<Vec<_>>());
    for step in 0..500 {
        // Refreshes of the inverse happen in scans.
        set.add(POSES + step % (CANDIDATES - POSES));
        set.best_addition().unwrap();
        set.remove(0);
        let (quick, exact) = (set.quick_value(), set.value());
        assert!((quick / exact - 1.0).abs() < 1e-8, "step {step}: {quick:e}, {exact:e}");
    }
}
