//! Moving chosen poses off the candidates.

use nalgebra::{Cholesky, DMatrix};

use super::Problem;
use crate::observability::{Block, FastForm, Spectrum};
use crate::pose::Pose;

/// First and smallest step, in half-ranges of the workspace.
const FIRST_STEP: f64 = 0.5;
const SMALLEST_STEP: f64 = 1.0 / 512.0;
/// Passes over all poses.
const PASSES: usize = 12;
/// A pass that gains less than this is the last.
const WORTH_IT: f64 = 1e-7;

/// Poses stay this far apart in some coordinate: the same pose measured twice would be another problem, for which the
/// bound does not hold.
const APART: f64 = 0.05;

/// Moves each pose along the coordinates of the workspace as long as the index gets better and the pose stays
/// feasible (a compass search); returns the value. Never makes the index worse. A pose that was moved loses its number.
pub(super) fn polish(problem: &Problem<'_>, poses: &mut [Pose], numbers: &mut [Option<usize>]) -> f64 {
    let workspace = &problem.campaign.workspace;
    let costly = !matches!(problem.index.fast(), FastForm::Determinant | FastForm::Trace(_));
    let (passes, smallest) = if costly { (3, 1.0 / 32.0) } else { (PASSES, SMALLEST_STEP) };
    let free: Vec<usize> = (0..6).filter(|k| workspace.half[*k] > 0.0).collect();
    let mut value = problem.value_of(poses);
    for _ in 0..passes {
        let before = value;
        for k in 0..poses.len() {
            let Some(rest) = Rest::of(problem, poses, k) else { continue };
            let mut u = coordinates(problem, &poses[k]);
            let others: Vec<[f64; 6]> =
                (0..poses.len()).filter(|other| *other != k).map(|other| coordinates(problem, &poses[other])).collect();
            let Ok(block) = problem.campaign.block(&poses[k]) else { continue };
            let Some(mut best) = rest.score(problem, &block) else { continue };
            let mut step = FIRST_STEP;
            while step >= smallest {
                let mut moved = false;
                for axis in &free {
                    for sign in [1.0, -1.0] {
                        let mut next = u;
                        next[*axis] = (u[*axis] + sign * step).clamp(-1.0, 1.0);
                        if next == u || others.iter().any(|other| distance(other, &next) < APART) {
                            continue;
                        }
                        let pose = problem.campaign.consistent(&workspace.pose(&next));
                        let Ok(block) = problem.campaign.feasible(&pose) else { continue };
                        if let Some(score) = rest.score(problem, &block).filter(|s| *s > best + 1e-12 * best.abs()) {
                            (best, u, poses[k], numbers[k]) = (score, next, pose, None);
                            moved = true;
                        }
                    }
                }
                if !moved {
                    step *= 0.5;
                }
            }
        }
        value = problem.value_of(poses);
        if (value - before).abs() < WORTH_IT * before.abs() {
            break;
        }
    }
    value
}

/// A pose in half-ranges of the workspace.
fn coordinates(problem: &Problem<'_>, pose: &Pose) -> [f64; 6] {
    let w = &problem.campaign.workspace;
    let offsets = w.offsets(pose);
    std::array::from_fn(|k| if w.half[k] > 0.0 { (offsets[k] / w.half[k]).clamp(-1.0, 1.0) } else { 0.0 })
}

/// The largest difference of two poses in half-ranges.
fn distance(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// All poses but one, ready to be scored with another in its place.
enum Rest {
    Determinant(DMatrix<f64>),
    Trace { inverse: DMatrix<f64>, middle: DMatrix<f64> },
    Rows { square: DMatrix<f64>, poses: usize },
}

impl Rest {
    fn of(problem: &Problem<'_>, poses: &[Pose], without: usize) -> Option<Self> {
        let others = poses.iter().enumerate().filter(|(k, _)| *k != without).map(|(_, pose)| pose);
        let visible = problem.candidates.pool.visible();
        let mut rows = problem.fixed_rows();
        for pose in others {
            let block = problem.campaign.block(pose).ok()?.rows()? * visible;
            let first = rows.nrows();
            rows = rows.resize_vertically(first + 6, 0.0);
            rows.rows_mut(first, 6).copy_from(&block);
        }
        let n = visible.ncols();
        if rows.nrows() < n {
            rows = rows.resize_vertically(n, 0.0);
        }
        let square = rows.qr().r();
        let fast = problem.index.fast();
        let inverse = || {
            let inverse = square.clone().try_inverse().filter(|m| m.iter().all(|v| v.is_finite()))?;
            Some(&inverse * inverse.transpose())
        };
        match fast {
            FastForm::Determinant => inverse().map(Self::Determinant),
            FastForm::Trace(gain) => {
                inverse().map(|inverse| Self::Trace { middle: &inverse * gain * &inverse, inverse })
            }
            _ => None,
        }
        .or_else(|| Some(Self::Rows { square: square.clone(), poses: poses.len() - 1 + problem.given.len() }))
    }

    /// Larger is better.
    fn score(&self, problem: &Problem<'_>, block: &Block) -> Option<f64> {
        let block = block.rows()? * problem.candidates.pool.visible();
        match self {
            Self::Determinant(inverse) => {
                let s = DMatrix::identity(6, 6) + &block * inverse * block.transpose();
                Some(0.5 * Cholesky::new(s)?.ln_determinant())
            }
            Self::Trace { inverse, middle } => {
                let s = DMatrix::identity(6, 6) + &block * inverse * block.transpose();
                let t = &block * middle * block.transpose();
                Some(Cholesky::new(s)?.solve(&t).trace())
            }
            Self::Rows { square, poses } => {
                let n = square.ncols();
                let mut rows = square.clone().resize_vertically(n + 6, 0.0);
                rows.rows_mut(n, 6).copy_from(&block);
                let value = problem.index.value(&Spectrum::of(&rows, poses + 1, problem.index.needs_directions()));
                Some(problem.index.goal().score(value))
            }
        }
    }
}
