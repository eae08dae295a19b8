//! Tests for unnamed causes of the residual that remains when every name has been tried.
//!
//! | test | sees |
//! |---|---|
//! | smooth: a polynomial of degree four in a covariate, on one leg | anything that changes slowly with what was recorded |
//! | jump: a step at one value of a covariate, on one leg | what latches, slips or switches at a temperature or an elevation |
//! | wave: a sine in commanded length, time or azimuth, up to the sampling limit | what repeats |
//! | scatter: the variance along one leg against the others | random errors of one leg, which depend on nothing recorded |
//! | size: χ² where the noise is known | everything else |
//!
//! A covariate and a leg are no cause; where covariates go together, another one explains nearly as much and is named
//! beside it.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::conditions::TIME;
use crate::diagnosis::answer::result::{Unknown, UnknownTest};
use crate::diagnosis::linear::hypotheses::EffectColumns;
use crate::diagnosis::linear::joint_functions::JointSamples;
use crate::diagnosis::linear::model::{Hypothesis, Model};
use crate::diagnosis::linear::statistics::upper_f;
use crate::diagnosis::search::covariates::Covariate;

/// Levels of the families of tests.
const SMOOTH: f64 = 1e-3;
const WAVE: f64 = 1e-3;
const JUMP: f64 = 5e-4;
const SCATTER: f64 = 5e-4;
const SIZE: f64 = 2e-3;
/// Samples on either side of a jump.
const FEW: usize = 3;
/// Most waves of one covariate: from one to about 256 cycles over its range. Each is a pass over all samples, so that all
/// of them up to the sampling limit would cost the square of the samples.
const MOST_WAVES: usize = 512;
/// Waves that are multiplied at once.
const WAVES_AT_ONCE: usize = 32;
/// Degree of the polynomial.
const DEGREE: usize = 4;

/// One finding of a smooth, a jump or a wave.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Finding<'a> {
    covariate: &'a str,
    leg: usize,
    gain: f64,
    /// Columns that the gain is of.
    rank: usize,
    /// Half the change of BIC: what it gains over its price, nats.
    worth: f64,
    period: Option<f64>,
    test: UnknownTest,
}

impl<'a> Finding<'a> {
    /// What a test of a covariate at a leg found: a gain from `rank` columns, at the price of so many parameters.
    fn of(
        test: UnknownTest,
        model: &Model,
        (covariate, leg): (&'a Covariate, usize),
        (gain, rank): (f64, usize),
        price: f64,
    ) -> Self {
        Self { covariate: &covariate.name, leg, gain, rank, worth: worth(model, gain, price), period: None, test }
    }

    /// Its probability by chance as one of so many tests, if that is below a level. The level is far below one hundredth.
    fn significant(&self, model: &Model, tests: f64, level: f64) -> Option<f64> {
        let noise = &model.noise;
        let p = noise.may_be_significant(self.gain, self.rank).then(|| noise.p_value(self.gain, self.rank) * tests)?;
        (p < level).then_some(p)
    }

    /// The same as an answer, with its probability.
    fn unknown(&self, p_value: f64) -> Unknown {
        Unknown {
            covariate: Some(self.covariate.to_owned()),
            leg: Some(self.leg),
            period: self.period,
            ..Unknown::by(self.test, p_value)
        }
    }
}

fn worth(model: &Model, gain: f64, parameters: f64) -> f64 {
    let noise = &model.noise;
    let fit =
        if noise.known { 0.5 * gain } else { -0.5 * noise.dof * (-(gain / noise.objective).min(1.0 - 1e-15)).ln_1p() };
    fit - 0.5 * parameters * noise.dof.ln()
}

/// Worth of these names together beside the parameters alone, nats.
pub(crate) fn worth_of(without: &Model, groups: &[EffectColumns], names: &[Hypothesis]) -> f64 {
    let (gain, rank) = without.ask_all(groups, names).gain();
    worth(without, gain, rank as f64)
}

/// A covariate with what the tests of each leg ask of it.
struct Prepared<'a> {
    covariate: &'a Covariate,
    /// Its values from -1 to 1.
    scaled: Vec<f64>,
    /// The samples by its values.
    order: Vec<usize>,
}

impl<'a> Prepared<'a> {
    fn all(covariates: &'a [Covariate]) -> Vec<Self> {
        let of = |covariate: &'a Covariate| {
            let values = &covariate.values;
            let mut order: Vec<usize> = (0..values.len()).collect();
            order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
            Self { covariate, scaled: covariate.scaled(), order }
        };
        covariates.iter().map(of).collect()
    }

    fn concerns(&self, leg: usize) -> bool {
        self.covariate.leg.is_none_or(|l| l == leg)
    }
}

/// Polynomials of degree 1 to 4 in each covariate that concerns a leg, on that leg.
fn smooths<'a>(
    model: &Model,
    (leg, on_leg): (usize, &JointSamples),
    covariates: &[Prepared<'a>],
    found: &mut Vec<Finding<'a>>,
) {
    let mine: Vec<&Prepared<'a>> = covariates.iter().filter(|c| c.concerns(leg)).collect();
    let mut functions = DMatrix::zeros(model.table().samples(), DEGREE * mine.len());
    for (m, covariate) in mine.iter().enumerate() {
        for (row, x) in covariate.scaled.iter().copied().enumerate() {
            // Legendre polynomials.
            let values = [x, 1.5 * x * x - 0.5, (2.5 * x * x - 1.5) * x, (4.375 * x * x - 3.75) * x * x + 0.375];
            for (d, v) in values.iter().enumerate() {
                functions[(row, DEGREE * m + d)] = *v;
            }
        }
    }
    for (c, asked) in mine.iter().zip(on_leg.ask(&functions, DEGREE)) {
        let (gain, rank) = asked.gain();
        if rank > 0 {
            found.push(Finding::of(UnknownTest::Smooth, model, (c.covariate, leg), (gain, rank), rank as f64));
        }
    }
}

/// A step at every value of each covariate that concerns a leg, on that leg.
fn jumps<'a>(
    model: &Model,
    (leg, on_leg): (usize, &JointSamples),
    covariates: &[Prepared<'a>],
    found: &mut Vec<Finding<'a>>,
) {
    let samples = model.table().samples();
    for c in covariates.iter().filter(|c| c.concerns(leg)) {
        let values = &c.covariate.values;
        for (at, gain) in on_leg.gains_from(&c.order).into_iter().enumerate().skip(FEW) {
            // Equal values stay together, and a few samples at either end are outliers and no step.
            if values[c.order[at]] == values[c.order[at - 1]] || at + FEW > samples {
                continue;
            }
            if let Some(gain) = gain {
                let jump = Finding::of(UnknownTest::Jump, model, (c.covariate, leg), (gain, 1), 1.0);
                // The place is chosen among all samples.
                found.push(Finding { worth: jump.worth - (samples as f64).ln(), ..jump });
            }
        }
    }
}

/// Sines in each covariate of waves, on a leg that it concerns, from one wave over the range to the sampling limit, in
/// steps of one half; no more than [`MOST_WAVES`].
fn waves<'a>(
    model: &Model,
    (leg, on_leg): (usize, &JointSamples),
    covariates: &[Prepared<'a>],
    found: &mut Vec<Finding<'a>>,
) {
    let samples = model.table().samples();
    let count = samples.saturating_sub(2).min(MOST_WAVES);
    for c in covariates.iter().filter(|c| c.covariate.waves && c.concerns(leg)) {
        // Half a cycle more turns the phase by the same angle each time.
        let turn: Vec<(f64, f64)> = c.scaled.iter().map(|x| (0.5 * PI * x).sin_cos()).collect();
        let mut phase: Vec<(f64, f64)> = c.scaled.iter().map(|x| (PI * x).sin_cos()).collect();
        let (low, high) = c.covariate.range();
        for first in (0..count).step_by(WAVES_AT_ONCE) {
            let number = WAVES_AT_ONCE.min(count - first);
            let mut functions = DMatrix::zeros(samples, 2 * number);
            for pair in functions.as_mut_slice().chunks_exact_mut(2 * samples) {
                let (sines, cosines) = pair.split_at_mut(samples);
                for (((sine, cosine), phase), step) in sines.iter_mut().zip(cosines).zip(&mut phase).zip(&turn) {
                    (*sine, *cosine) = *phase;
                    *phase = (phase.0 * step.1 + phase.1 * step.0, phase.1 * step.1 - phase.0 * step.0);
                }
            }
            for (k, (gain, rank)) in on_leg.gains_of_pairs(&functions).into_iter().enumerate() {
                if rank > 0 {
                    // Sine, cosine and the period.
                    let wave = Finding::of(UnknownTest::Wave, model, (c.covariate, leg), (gain, rank), 3.0);
                    let cycles = 1.0 + 0.5 * (first + k) as f64;
                    found.push(Finding { period: Some((high - low) / cycles), ..wave });
                }
            }
        }
    }
}

/// Residual along each leg, squared, and across it, over what the noise would give: `(Σ z²/(1 - h), number, the same
/// across)`.
fn scatter(model: &Model) -> Vec<(usize, f64)> {
    let table = model.table();
    let mut found = Vec::new();
    for leg in 0..table.joints.len() {
        let (mut along, mut dof_along, mut across, mut dof_across) = (0.0, 0.0, 0.0, 0.0);
        for (first, n) in model.kept.rows() {
            let v = table.a_t.view((table.joints.start + leg, first), (1, n)).transpose();
            let length = v.norm();
            if n < 2 || length == 0.0 {
                continue;
            }
            let d: DVector<f64> = v.column(0) / length;
            let r = model.residual.rows(first, n);
            let q_t = model.leverage(first, n);
            let z = d.dot(&r);
            let h = (q_t * &d).norm_squared();
            along += z * z;
            dof_along += 1.0 - h;
            across += r.norm_squared() - z * z;
            dof_across += n as f64 - 1.0 - (q_t.norm_squared() - h);
        }
        if dof_along > 5.0 && dof_across > 5.0 && across > 0.0 {
            let f = (along / dof_along) / (across / dof_across);
            found.push((leg, upper_f(f, dof_along, dof_across)));
        }
    }
    found
}

/// The most telling of what is left, or nothing.
pub(crate) fn remainder(model: &Model, covariates: &[Covariate]) -> Option<Unknown> {
    if model.is_rounding() {
        return None;
    }
    let prepared = Prepared::all(covariates);
    let mut families = [(Vec::new(), SMOOTH), (Vec::new(), WAVE), (Vec::new(), JUMP)];
    let [(smooth, _), (wave, _), (jump, _)] = &mut families;
    for leg in 0..model.table().joints.len() {
        let on_leg = (leg, &model.joint_samples(leg));
        smooths(model, on_leg, &prepared, smooth);
        waves(model, on_leg, &prepared, wave);
        jumps(model, on_leg, &prepared, jump);
    }
    let mut findings = Vec::new();
    for (family, level) in &families {
        let tests = family.len().max(1) as f64;
        findings.extend(family.iter().filter_map(|f| Some((*f, f.significant(model, tests, *level)?.min(1.0)))));
    }
    findings.sort_by(|(a, _), (b, _)| b.worth.total_cmp(&a.worth));
    let scattered = scatter(model);
    let worst = scattered.iter().min_by(|a, b| a.1.total_cmp(&b.1)).copied();
    let scatter = worst.filter(|(_, p)| p * (scattered.len() as f64) < SCATTER);
    if let Some((best, p)) = findings.first() {
        let other = findings.iter().find(|(f, _)| f.covariate != best.covariate && f.worth > best.worth - 3.0);
        return Some(Unknown { runner_up: other.map(|(f, _)| f.covariate.to_owned()), ..best.unknown(*p) });
    }
    if let Some((leg, p)) = scatter {
        return Some(Unknown { leg: Some(leg), ..Unknown::by(UnknownTest::Scatter, p * scattered.len() as f64) });
    }
    if model.noise.known {
        let p = ChiSquared::new(model.noise.dof).map_or(1.0, |d| d.sf(model.noise.rss));
        if p < SIZE {
            return Some(Unknown::by(UnknownTest::Size, p));
        }
    }
    None
}

/// The unknown that explains more than all names together, if there is one: its worth beside no names against theirs.
pub(crate) fn rival(without: &Model, covariates: &[Covariate], worth_of_names: f64, margin: f64) -> Option<Unknown> {
    let prepared = Prepared::all(covariates);
    let mut all = Vec::new();
    let mut steps = Vec::new();
    for leg in 0..without.table().joints.len() {
        let on_leg = (leg, &without.joint_samples(leg));
        smooths(without, on_leg, &prepared, &mut all);
        jumps(without, on_leg, &prepared, &mut steps);
    }
    // Steps in time have names.
    all.extend(steps.into_iter().filter(|f| f.covariate != TIME && f.covariate != "row"));
    let tests = all.len() as f64;
    let best = all.into_iter().max_by(|a, b| a.worth.total_cmp(&b.worth))?;
    // What is not significant by itself withdraws nothing.
    let significant = best.significant(without, tests, SMOOTH).is_some();
    let p_value = || without.noise.p_value(best.gain, best.rank);
    (significant && best.worth > worth_of_names + margin).then(|| best.unknown(p_value()))
}
