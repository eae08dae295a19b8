//! Readings of a file in the tracker's frame: for each the joints lead to poses, whose moves must be as large as the
//! measured ones; then the frames are found, and the distances that are left are compared.

use crate::diagnosis::preflight::in_base::Screened;
use crate::diagnosis::preflight::joint_columns::JointColumns;
use crate::diagnosis::preflight::mistakes::Mistake;
use crate::diagnosis::preflight::reading::Reading;
use crate::diagnosis::preflight::regression::median;
use crate::diagnosis::preflight::trial::Trial;
use crate::mechanism::characteristic_length;
use crate::pose::{Pose, rotation_vector};
use crate::units::Dimension;

/// Readings whose frames are found.
const MOST: usize = 28;
/// Readings of the joints and of the poses that are tried together.
const FIRST: usize = 8;
/// Moves may disagree this many times more than in the best reading.
const WORSE: f64 = 12.0;
/// More legs are not exchanged or turned in every way.
const LEGS: usize = 6;

/// The readings that are worth finding frames for, with the disagreement of their moves.
pub(crate) fn worth_finding(trial: &Trial<'_>) -> Vec<Screened> {
    let mistakes = trial.mistakes();
    let as_stated = trial.stated();
    let few: Vec<usize> = trial.few.iter().step_by(3).copied().collect();
    let with = |joints| Reading { joints, ..as_stated.clone() };
    let mut quick: Vec<Screened> =
        joint_columns(trial).into_iter().filter_map(|joints| screened(trial, with(joints), &few)).collect();
    sort(&mut quick);
    quick.truncate(2 * MOST);
    let mut by_joints: Vec<Screened> =
        quick.into_iter().filter_map(|s| screened(trial, s.reading, &trial.few)).collect();
    let of = |mistakes: Vec<Mistake>, joints: &JointColumns| {
        screened(trial, Reading { mistakes, joints: joints.clone() }, &trial.few)
    };
    let mut by_poses: Vec<Screened> = mistakes.iter().filter_map(|m| of(vec![m.clone()], &as_stated.joints)).collect();
    sort(&mut by_joints);
    sort(&mut by_poses);
    let mut all: Vec<Screened> = Vec::new();
    for (k, one) in by_poses.iter().take(FIRST).enumerate() {
        let one = &one.reading.mistakes[0];
        let before = |m: &&Mistake| by_poses[..k].iter().any(|s| s.reading.mistakes[0] == **m);
        let others = mistakes.iter().filter(|m| m.goes_with(one) && !before(m));
        all.extend(others.filter_map(|m| of(vec![one.clone(), m.clone()], &as_stated.joints)));
    }
    for joints in by_joints.iter().take(FIRST) {
        all.extend(mistakes.iter().filter_map(|m| of(vec![m.clone()], &joints.reading.joints)));
    }
    sort(&mut all);
    let mut found = Vec::new();
    for (mut some, count) in [(by_joints, MOST), (by_poses, MOST), (all, MOST / 2)] {
        some.truncate(count);
        found.extend(some);
    }
    let least = found.iter().map(|s| s.left).fold(f64::INFINITY, f64::min);
    found.retain(|s| s.left <= WORSE * least.max(1e-4));
    found
}

fn sort(all: &mut [Screened]) {
    all.sort_by(|a, b| a.left.total_cmp(&b.left));
}

/// How much the moves from row to row disagree, over the measured ones: turns, which are as large in every frame, and shifts.
fn screened(trial: &Trial<'_>, reading: Reading, rows: &[usize]) -> Option<Screened> {
    let size = characteristic_length(trial.mechanism);
    // What leads nowhere takes longest to find out.
    let first = trial.table.commanded(trial.mechanism, &reading, &rows[..rows.len().min(3)]);
    if first.iter().flatten().count() < 2 {
        return None;
    }
    let commanded = trial.table.commanded(trial.mechanism, &reading, rows);
    let reached = commanded.iter().flatten().count();
    if 10 * reached < 6 * rows.len() {
        return None;
    }
    let pairs: Vec<(Pose, Pose, bool)> = rows
        .iter()
        .zip(commanded)
        .filter_map(|(row, nominal)| {
            let nominal = nominal?;
            if let Some(point) = trial.table.point(&reading, *row) {
                let seen = Pose { position: point.position, ..nominal };
                return Some((Pose { position: nominal.place(&point.place), ..nominal }, seen, false));
            }
            Some((nominal, trial.table.measured(&reading, *row)?, true))
        })
        .collect();
    let (mut turns, mut shifts, mut whole) = (Vec::new(), Vec::new(), [0.0_f64; 2]);
    for (k, (nominal, seen, turned)) in pairs.iter().enumerate() {
        // Each row with the next and with one far away.
        for other in [k + 1, k + pairs.len() / 2].map(|j| &pairs[j % pairs.len()]) {
            let moved = |a: &Pose, b: &Pose| (b.position - a.position).norm();
            let (asked, measured) = (moved(nominal, &other.0), moved(seen, &other.1));
            shifts.push((asked - measured).abs());
            whole[0] = whole[0].max(measured);
            if *turned {
                let turn = |a: &Pose, b: &Pose| rotation_vector(&(b.rotation * a.rotation.inverse())).norm();
                let (asked, measured) = (turn(nominal, &other.0), turn(seen, &other.1));
                turns.push(size * (asked - measured).abs());
                whole[1] = whole[1].max(size * measured);
            }
        }
    }
    let part = |v: Vec<f64>, whole: f64| if v.is_empty() { 0.0 } else { median(v) / (whole + 1e-3 * size) };
    let left = part(turns, whole[1]) + 0.3 * part(shifts, whole[0]);
    left.is_finite().then_some(Screened { reading, left })
}

/// Readings of the columns of the joints: every order, every set of signs, and joints that count from home.
fn joint_columns(trial: &Trial<'_>) -> Vec<JointColumns> {
    let mechanism = trial.mechanism;
    let n = mechanism.joints().len();
    let Ok(home) = mechanism.inverse(mechanism.values(), &mechanism.home(), &Default::default()) else {
        return Vec::new();
    };
    let mut all: Vec<JointColumns> = orders(n).into_iter().map(JointColumns::in_order).collect();
    let angles = mechanism.joints().iter().any(|j| j.dimension != Dimension::Length);
    for about in [home.clone(), vec![0.0; n]].into_iter().take(if angles { 2 } else { 1 }) {
        let sets: Vec<Vec<bool>> = match n <= LEGS {
            true => (1..1_usize << n).map(|bits| (0..n).map(|i| bits >> i & 1 == 1).collect()).collect(),
            false => (0..n).map(|k| (0..n).map(|i| i == k).collect()).chain([vec![true; n]]).collect(),
        };
        all.extend(sets.into_iter().map(|set| JointColumns::with_signs(set, &about)));
    }
    if home.iter().all(|h| *h != 0.0) {
        all.push(JointColumns { zero: home, counted_from_elsewhere: true, ..JointColumns::stated(n) });
    }
    all
}

/// All orders of a few legs but the stated one; of more the exchanges of two.
fn orders(n: usize) -> Vec<Vec<usize>> {
    let stated: Vec<usize> = (0..n).collect();
    if n > LEGS {
        let exchange = |i: usize, k: usize| {
            let mut order = stated.clone();
            order.swap(i, k);
            order
        };
        return (0..n).flat_map(|i| (0..i).map(move |k| (i, k))).map(|(i, k)| exchange(i, k)).collect();
    }
    let mut all = vec![Vec::new()];
    for _ in 0..n {
        let longer = |order: Vec<usize>| {
            let missing: Vec<usize> = (0..n).filter(|k| !order.contains(k)).collect();
            missing.into_iter().map(move |k| order.iter().copied().chain([k]).collect::<Vec<usize>>())
        };
        all = all.into_iter().flat_map(longer).collect();
    }
    all.retain(|order| *order != stated);
    all
}
