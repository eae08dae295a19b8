//! The joints that the measured poses ask for, over the columns of the file: which column goes with which joint, with
//! which sign, unit and zero.
//!
//! A joint is its column times ±1 (times a ratio of units) plus a constant, up to what the tolerances bend. Medians stand for
//! sums, so that gross rows do not count.

use nalgebra::DMatrix;

use crate::diagnosis::preflight::assignment::best_assignment;
use crate::diagnosis::preflight::joint_columns::JointColumns;
use crate::diagnosis::preflight::unit_factors::UnitFactor;
use crate::mechanism::{Mechanism, characteristic_length};
use crate::units::Dimension;

/// Another order or sign must leave this part of what the stated one leaves.
const BETTER: f64 = 0.5;
/// A zero beyond this part of the joint at home, or of the size of the mechanism, is no convention.
const GROSS_LENGTH: f64 = 0.25;
/// The same for angles, rad.
const GROSS_ANGLE: f64 = 0.35;
/// Zeros that differ from those of home, or from each other, by less than this part are the same.
const SAME: f64 = 0.15;
/// Ratio of a spread to that of a unit, up to which it is that unit.
const UNIT: f64 = 1.5;
/// Part of the size below which a joint does not move.
const STILL: f64 = 1e-5;
/// More joints are not exchanged.
const MOST: usize = 8;

/// The columns that go best with the joints asked for.
#[derive(Clone, Debug)]
pub(crate) struct Regression {
    pub(crate) columns: JointColumns,
    /// What is left of each joint over its spread: near 0 where all agree, near 1 where nothing does.
    pub(crate) left: f64,
    /// The same with the columns as they are stated, and the zeros that they would have.
    pub(crate) left_as_stated: f64,
    /// True if the columns as stated count from elsewhere by more than a convention.
    pub(crate) stated_from_elsewhere: bool,
}

/// One joint over one column.
#[derive(Clone, Copy)]
struct Line {
    reversed: bool,
    zero: f64,
    left: f64,
}

/// Regresses asked joints (by row) over columns (by row).
pub(crate) fn regress(
    mechanism: &dyn Mechanism,
    asked: &[Vec<f64>],
    stated: &[Vec<f64>],
    reached: bool,
) -> Option<Regression> {
    let n = mechanism.joints().len();
    if asked.len() < 6 || n > MOST {
        return None;
    }
    let column = |of: &[Vec<f64>], k: usize| -> Vec<f64> { of.iter().map(|row| row[k]).collect() };
    let asked: Vec<Vec<f64>> = (0..n).map(|k| column(asked, k)).collect();
    let stated: Vec<Vec<f64>> = (0..n).map(|k| column(stated, k)).collect();
    let unit = unit(mechanism, &asked, &stated);
    let factor = unit.as_ref().map_or(1.0, |u| u.factor);
    let still = STILL * characteristic_length(mechanism);
    let line = |i: usize, k: usize, factor: f64| line(&asked[i], &stated[k], factor, still);
    let same = |i: usize, k: usize| mechanism.joints()[i].dimension == mechanism.joints()[k].dimension;
    let lines: Vec<Vec<Line>> = (0..n).map(|i| (0..n).map(|k| line(i, k, factor)).collect()).collect();
    let score = DMatrix::from_fn(n, n, |i, k| {
        let goodness = -(lines[i][k].left + 1e-6).ln();
        if same(i, k) { goodness } else { goodness - 1e3 }
    });
    let mut order = best_assignment(&score);
    let sum = |order: &[usize]| order.iter().enumerate().map(|(i, k)| score[(i, *k)]).sum::<f64>();
    let identity: Vec<usize> = (0..n).collect();
    // Every joint that changes its place must go clearly better with the other column.
    let moved = order.iter().enumerate().filter(|(i, k)| i != *k).count() as f64;
    if sum(&order) + moved * BETTER.ln() <= sum(&identity) {
        order.clone_from(&identity);
    }
    let chosen: Vec<Line> = order.iter().enumerate().map(|(i, k)| lines[i][*k]).collect();
    let as_stated: Vec<Line> = (0..n).map(|i| upright(&asked[i], &stated[i], 1.0, still)).collect();
    let upright_zeros: Vec<f64> = as_stated.iter().map(|l| l.zero).collect();
    let home = mechanism.inverse(mechanism.values(), &mechanism.home(), &Default::default()).ok()?;
    Some(Regression {
        columns: columns(mechanism, order, unit, &chosen, &home, reached),
        left: rms(&chosen),
        left_as_stated: rms(&as_stated),
        stated_from_elsewhere: zeros(mechanism, &upright_zeros, &vec![false; n], &home, reached).is_some(),
    })
}

/// The columns with their signs and zeros.
fn columns(
    mechanism: &dyn Mechanism,
    order: Vec<usize>,
    unit: Option<UnitFactor>,
    chosen: &[Line],
    home: &[f64],
    reached: bool,
) -> JointColumns {
    let reversed: Vec<bool> = chosen.iter().map(|l| l.reversed).collect();
    let found: Vec<f64> = chosen.iter().map(|l| l.zero).collect();
    let elsewhere = zeros(mechanism, &found, &reversed, home, reached);
    let counted_from_elsewhere = elsewhere.is_some();
    // About which coordinate a joint counts the other way is not known beforehand: home, zero, or the end of its stroke.
    let usual = |i: usize| if reversed[i] { found[i] } else { 0.0 };
    let zero = elsewhere.unwrap_or_else(|| (0..found.len()).map(usual).collect());
    JointColumns { order, reversed, unit, zero, counted_from_elsewhere }
}

/// The zeros, if they are farther from where the drawing has them than a convention would put them.
fn zeros(mechanism: &dyn Mechanism, found: &[f64], reversed: &[bool], home: &[f64], reached: bool) -> Option<Vec<f64>> {
    let n = found.len();
    let size = characteristic_length(mechanism);
    let mean_home = home.iter().map(|h| h.abs()).sum::<f64>() / n as f64;
    let gross = |i: usize| {
        let limit = match mechanism.joints()[i].dimension {
            Dimension::Length => GROSS_LENGTH * mean_home.max(size),
            _ => GROSS_ANGLE,
        };
        // What does not reach a pose is no convention either.
        let limit = if reached { limit } else { 0.2 * limit };
        let off = if reversed[i] { found[i].abs().min((found[i] - 2.0 * home[i]).abs()) } else { found[i].abs() };
        off > limit
    };
    if !(0..n).all(gross) {
        return None;
    }
    let near = |a: f64, b: f64| (a - b).abs() < SAME * b.abs();
    if found.iter().zip(home).all(|(z, h)| near(*z, *h)) {
        return Some(home.to_vec());
    }
    let middle = median(found.to_vec());
    Some(if found.iter().all(|z| near(*z, middle)) { vec![middle; n] } else { found.to_vec() })
}

/// The ratio of units by which the joints asked for spread more than the columns.
fn unit(mechanism: &dyn Mechanism, asked: &[Vec<f64>], stated: &[Vec<f64>]) -> Option<UnitFactor> {
    let dimension = mechanism.joints().first()?.dimension;
    if mechanism.joints().iter().any(|j| j.dimension != dimension) {
        return None;
    }
    let spread = |all: &[Vec<f64>]| all.iter().map(|v| spread(v)).sum::<f64>();
    let ratio = spread(asked) / spread(stated);
    let off = |factor: f64| (ratio / factor).ln().abs();
    let all = if dimension == Dimension::Length { UnitFactor::lengths() } else { UnitFactor::angles() };
    let best = all.into_iter().min_by(|a, b| off(a.factor).total_cmp(&off(b.factor)))?;
    (off(best.factor) < off(1.0) && off(best.factor) < UNIT.ln()).then_some(best)
}

/// A joint over a column with the sign that leaves less.
fn line(asked: &[f64], stated: &[f64], factor: f64, still: f64) -> Line {
    let (plus, minus) = (upright(asked, stated, factor, still), upright(asked, stated, -factor, still));
    if minus.left < BETTER * plus.left { Line { reversed: true, ..minus } } else { plus }
}

/// A joint over a column times a factor.
fn upright(asked: &[f64], stated: &[f64], factor: f64, still: f64) -> Line {
    let difference: Vec<f64> = asked.iter().zip(stated).map(|(a, s)| a - factor * s).collect();
    let zero = median(difference.clone());
    let whole = spread(asked) + factor.abs() * spread(stated) + still;
    Line { reversed: false, zero, left: spread(&difference) / whole }
}

/// Root mean square of what is left.
fn rms(lines: &[Line]) -> f64 {
    (lines.iter().map(|l| l.left * l.left).sum::<f64>() / lines.len() as f64).sqrt()
}

/// Median distance from the median.
fn spread(values: &[f64]) -> f64 {
    let middle = median(values.to_vec());
    median(values.iter().map(|v| (v - middle).abs()).collect())
}

/// The upper of the middle values; no number of none.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
