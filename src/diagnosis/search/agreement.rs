//! Does what is left agree with the noise: with the stated one, and with samples that repeat each other?
//!
//! Where commands and conditions come again, the scatter among these samples *is* the noise, whatever was stated (a pure-error
//! test of the lack of fit). Samples that were left out and are alike in a condition are no accidents.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::conditions::{ConditionKind, ConditionTable, TIME};
use crate::diagnosis::answer::unknown::{Unknown, UnknownTest};
use crate::diagnosis::linear::hypotheses::EffectColumns;
use crate::diagnosis::linear::hypothesis::Hypothesis;
use crate::diagnosis::linear::model::Model;
use crate::diagnosis::linear::spreads::Spreads;
use crate::diagnosis::linear::statistics::upper_f;
use crate::diagnosis::search::covariates::Covariate;
use crate::measurement::{Dataset, RowKind};

/// A misfit as likely as this is none of the noise; as in a calibration.
const BEYOND_CHANCE: f64 = 1e-6;
/// Position noise over rotation noise may differ from the stated ratio by this factor.
const OTHER_RATIO: f64 = 1.5;
/// Degrees of freedom from which on repeated samples tell their noise.
const FEWEST_REPEATS: f64 = 6.0;
/// Joints and conditions that differ by this part of their range are the same.
const SAME: f64 = 1e-6;

/// What is left beside the stated noise, if it is beyond chance; the size is their ratio.
pub(crate) fn noise_exceeded(model: &Model, spreads: &Spreads) -> Option<Unknown> {
    let table = model.table();
    // Of the rows as they are stated, not as they were weighted.
    let (mut squares, mut weighted) = (0.0, 0.0);
    for (k, (first, n)) in table.rows.iter().enumerate().filter(|(k, _)| !model.kept.is_out(*k)) {
        for row in *first..first + n {
            let spread = if spreads.joints.is_empty() { spreads.of_row(k, || 0, table.kinds[row]) } else { 1.0 };
            squares += (spread * model.residual[row]).powi(2);
            weighted += model.residual[row].powi(2);
        }
    }
    let free = model.noise.dof;
    let chi_square = model.noise.rss * squares / weighted;
    let p = ChiSquared::new(free).map_or(1.0, |d| d.sf(chi_square));
    let ratio = spreads.kinds.map_or(1.0, |[position, rotation]| position / rotation);
    let scale = (chi_square / free).sqrt();
    let exceeds = p < BEYOND_CHANCE;
    let is_other = !(1.0 / OTHER_RATIO..=OTHER_RATIO).contains(&ratio);
    let size = if exceeds { scale } else { ratio.max(1.0 / ratio) };
    (exceeds || is_other).then(|| Unknown { size: Some(size), ..Unknown::by(UnknownTest::Size, p) })
}

/// What is left beyond the noise of repeated samples.
#[derive(Debug)]
pub(crate) struct LackOfFit {
    /// The probability of so much by chance.
    pub(crate) p_value: f64,
    /// Its root mean square over that of the noise.
    pub(crate) times: f64,
    /// Its variance in whitened rows, and the degrees of freedom of that.
    variance: f64,
    free: f64,
    /// The samples that repeat each other, and those that repeat none.
    groups: Vec<Vec<usize>>,
}

impl LackOfFit {
    /// What is left beside the noise of repeated samples, if it is beyond chance. Where no commands come again with all
    /// conditions, those that the catalogue does not know are let differ; what they do then counts as noise.
    pub(crate) fn of(model: &Model, data: &Dataset, kinds: &ConditionTable) -> Option<Self> {
        let all = |name: &str| name != TIME;
        let known = |name: &str| name != TIME && kinds.of(name).is_some_and(ConditionKind::is_recorded);
        let ((pure, free), groups) = [repeats(data, &all), repeats(data, &known)]
            .into_iter()
            .map(|groups| (pure_error(model, &groups), groups))
            .find(|((_, free), _)| *free >= FEWEST_REPEATS)?;
        let (lack, rest) = (model.noise.rss - pure, model.noise.dof - free);
        if rest < FEWEST_REPEATS || !(pure > 0.0) {
            return None;
        }
        let f = (lack / rest) / (pure / free);
        let p_value = upper_f(f, rest, free);
        (p_value < BEYOND_CHANCE).then(|| Self { p_value, times: f.sqrt(), variance: lack / rest, free: rest, groups })
    }

    /// The probability that what names explain beside the model `without` is chance, as samples that repeat each other do not
    /// repeat it by chance: each group of them counts as one (Hotelling's T² of the scores of the groups). Where there are too
    /// few groups, that of the gain if what is left were all noise.
    pub(crate) fn chance_of(&self, without: &Model, groups: &[EffectColumns], names: &[Hypothesis]) -> f64 {
        let asked = without.ask_all(groups, names);
        let (gain, rank) = asked.gain();
        let clusters = self.groups.len() as f64;
        let p = rank as f64;
        if rank == 0 {
            return 1.0;
        }
        if clusters < p + FEWEST_REPEATS {
            return upper_f(gain / p / self.variance, p, self.free);
        }
        let table = without.table();
        let columns: Vec<DMatrix<f64>> =
            names.iter().map(|name| without.projected(without.kept.columns(&name.block(groups, table)))).collect();
        let width = columns.iter().map(DMatrix::ncols).sum();
        let mut scores = DMatrix::zeros(width, self.groups.len());
        for (mut score, group) in scores.column_iter_mut().zip(&self.groups) {
            for (first, n) in group.iter().filter(|k| !without.kept.is_out(**k)).map(|k| table.rows[*k]) {
                let all = columns.iter().flat_map(DMatrix::column_iter);
                let residual = without.residual.rows(first, n);
                score.iter_mut().zip(all).for_each(|(s, column)| *s += column.rows(first, n).dot(&residual));
            }
        }
        let scores = asked.along_seen(&scores);
        let sum = scores.column_sum();
        let square = &scores * scores.transpose();
        let Some(factor) = square.cholesky() else { return 1.0 };
        let part = (sum.dot(&factor.solve(&sum)) / clusters).min(1.0 - 1e-15);
        upper_f((clusters - p) / p * part / (1.0 - part), p, clusters - p)
    }
}

/// The sum of squares of samples about the mean of those that they repeat, and its degrees of freedom.
fn pure_error(model: &Model, groups: &[Vec<usize>]) -> (f64, f64) {
    let table = model.table();
    let (mut pure, mut free) = (0.0, 0.0);
    for group in groups.iter().filter(|group| group.len() > 1) {
        let rows: Vec<DVector<f64>> = group
            .iter()
            .filter(|k| !model.kept.is_out(**k))
            .map(|k| model.residual.rows(table.rows[*k].0, table.rows[*k].1).into_owned())
            .collect();
        let Some(first) = rows.first().filter(|first| rows.iter().all(|r| r.len() == first.len())) else { continue };
        let mean = rows.iter().fold(DVector::zeros(first.len()), |sum, r| sum + r) / rows.len() as f64;
        pure += rows.iter().map(|r| (r - &mean).norm_squared()).sum::<f64>();
        free += ((rows.len() - 1) * first.len()) as f64;
    }
    (pure / model.inflation, free / model.inflation)
}

/// Samples of the same commands in the same conditions, of those that count.
fn repeats(data: &Dataset, counts: &dyn Fn(&str) -> bool) -> Vec<Vec<usize>> {
    let values = |k: usize| -> Vec<f64> {
        let sample = data.sample(k);
        let conditions = sample.conditions.covariates.iter().filter(|(name, _)| counts(name)).map(|(_, v)| *v);
        sample.joints.iter().copied().chain(conditions).collect()
    };
    let all: Vec<Vec<f64>> = (0..data.len()).map(values).collect();
    let width = all.iter().map(Vec::len).min().unwrap_or(0);
    let range = |c: usize| {
        let column = all.iter().map(|row| row[c]);
        column.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    };
    let steps: Vec<(f64, f64)> = (0..width).map(range).map(|(low, high)| (low, SAME * (high - low))).collect();
    let mut groups: BTreeMap<Vec<i64>, Vec<usize>> = BTreeMap::new();
    for (k, row) in all.iter().enumerate() {
        let cell =
            |(v, (low, step)): (&f64, &(f64, f64))| if *step > 0.0 { ((v - low) / step).round() as i64 } else { 0 };
        groups.entry(row.iter().zip(&steps).map(cell).collect()).or_default().push(k);
    }
    groups.into_values().collect()
}

/// The covariate by which samples that were left out differ from the others, if there is one: nearly all of them beyond a
/// value, and nearly none of the others.
pub(crate) fn left_out_by<'a>(left_out: &[usize], covariates: &'a [Covariate]) -> Option<&'a Covariate> {
    const FEW: usize = 4;
    const LEVEL: f64 = 1e-5;
    if left_out.len() < FEW {
        return None;
    }
    let tests = covariates.len() as f64;
    let chance = |c: &&Covariate| rank_sum(left_out, &c.values);
    let best = covariates.iter().min_by(|a, b| chance(a).total_cmp(&chance(b)))?;
    (chance(&best) * tests < LEVEL).then_some(best)
}

/// Probability that the ranks of some samples differ so much from those of the others by chance (Wilcoxon, with ties).
fn rank_sum(some: &[usize], values: &[f64]) -> f64 {
    let n = values.len();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; n];
    let (mut at, mut ties) = (0, 0.0);
    while at < n {
        let end = (at..n).find(|k| values[order[*k]] != values[order[at]]).unwrap_or(n);
        order[at..end].iter().for_each(|k| ranks[*k] = 0.5 * (at + end + 1) as f64);
        let t = (end - at) as f64;
        ties += t * (t * t - 1.0);
        at = end;
    }
    let (m, n) = (some.len() as f64, n as f64);
    let sum: f64 = some.iter().map(|k| ranks[*k]).sum();
    let variance = m * (n - m) / 12.0 * (n + 1.0 - ties / (n * (n - 1.0)));
    if !(variance > 0.0) {
        return 1.0;
    }
    let z = (sum - 0.5 * m * (n + 1.0)) / variance.sqrt();
    ChiSquared::new(1.0).map_or(1.0, |d| d.sf(z * z))
}

/// The readings that never change although the commands ask for it, in words; `None` if the instrument moves.
pub(crate) fn stuck(data: &Dataset, at_home: &[DVector<f64>], as_commanded: &[DVector<f64>]) -> Option<String> {
    let kinds = data.rows(0);
    let same_rows = |all: &[DVector<f64>]| all.iter().all(|r| r.len() == kinds.len());
    if data.len() < 3 || !same_rows(at_home) || !same_rows(as_commanded) {
        return None;
    }
    let range = |of: &dyn Fn(usize) -> f64| {
        let all = (0..data.len()).map(of);
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        high - low
    };
    let still: Vec<usize> = (0..kinds.len())
        .filter(|row| {
            let read = range(&|k| at_home[k][*row]);
            let asked = range(&|k| at_home[k][*row] - as_commanded[k][*row]);
            asked > STUCK && read < STUCK_AT * asked
        })
        .collect();
    if still.is_empty() {
        return None;
    }
    let of = |kind: RowKind| still.iter().filter(|row| kinds[**row] == kind).count();
    let counted = |n: usize, what: &str| (n > 0).then(|| format!("{n} {what}{}", if n == 1 { "" } else { "s" }));
    let words = [counted(of(RowKind::Position), "measured position"), counted(of(RowKind::Rotation), "measured angle")];
    let words: Vec<String> = words.into_iter().flatten().collect();
    Some(format!(
        "{} of each sample never change although the commands do: the instrument stands still, or one reading was copied \
         into all rows",
        words.join(" and ")
    ))
}

/// Commands that move a reading by this many σ should be seen, and are not if it changes by less than this part of it.
const STUCK: f64 = 100.0;
const STUCK_AT: f64 = 1e-6;
