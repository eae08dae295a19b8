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

use nalgebra::DMatrix;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::conditions::TIME;
use crate::diagnosis::answer::result::{Unknown, UnknownTest};
use crate::diagnosis::linear::hypotheses::EffectColumns;
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
/// Degree of the polynomial.
const DEGREE: usize = 4;

/// One finding of a smooth, a jump or a wave.
#[derive(Clone, Debug)]
pub(crate) struct Finding {
    covariate: String,
    leg: usize,
    p_value: f64,
    /// Half the change of BIC: what it gains over its price, nats.
    worth: f64,
    period: Option<f64>,
    test: UnknownTest,
}

impl Finding {
    /// What a test of a covariate at a leg found: a gain from `rank` columns, at the price of so many parameters.
    fn of(
        test: UnknownTest,
        model: &Model<'_>,
        (covariate, leg): (&Covariate, usize),
        (gain, rank): (f64, usize),
        price: f64,
    ) -> Self {
        Self {
            covariate: covariate.name.clone(),
            leg,
            p_value: model.noise.p_value(gain, rank),
            worth: worth(model, gain, price),
            period: None,
            test,
        }
    }

    /// The same as an answer.
    fn unknown(&self) -> Unknown {
        Unknown {
            covariate: Some(self.covariate.clone()),
            leg: Some(self.leg),
            period: self.period,
            ..Unknown::by(self.test, self.p_value)
        }
    }
}

fn worth(model: &Model<'_>, gain: f64, parameters: f64) -> f64 {
    let noise = &model.noise;
    let fit =
        if noise.known { 0.5 * gain } else { -0.5 * noise.dof * (-(gain / noise.objective).min(1.0 - 1e-15)).ln_1p() };
    fit - 0.5 * parameters * noise.dof.ln()
}

/// Worth of these names together beside the parameters alone, nats.
pub(crate) fn worth_of(without: &Model<'_>, groups: &[EffectColumns], names: &[Hypothesis]) -> f64 {
    let (gain, rank) = without.ask_all(groups, names).gain();
    worth(without, gain, rank as f64)
}

/// Polynomials of degree 1 to 4 in each covariate that concerns a leg, on that leg.
pub(crate) fn smooths(model: &Model<'_>, covariates: &[Covariate]) -> Vec<Finding> {
    let mut found = Vec::new();
    for leg in 0..model.table.joints.len() {
        let mine: Vec<&Covariate> = covariates.iter().filter(|c| c.leg.is_none_or(|l| l == leg)).collect();
        let mut functions = DMatrix::zeros(model.table.samples(), DEGREE * mine.len());
        for (m, covariate) in mine.iter().enumerate() {
            for (row, x) in covariate.scaled().into_iter().enumerate() {
                // Legendre polynomials.
                let values = [x, 1.5 * x * x - 0.5, (2.5 * x * x - 1.5) * x, (4.375 * x * x - 3.75) * x * x + 0.375];
                for (d, v) in values.iter().enumerate() {
                    functions[(row, DEGREE * m + d)] = *v;
                }
            }
        }
        let asked = model.joint_functions(leg, &functions);
        for (m, covariate) in mine.iter().enumerate() {
            let (gain, rank) = asked.ask(DEGREE * m..DEGREE * (m + 1)).gain();
            if rank > 0 {
                found.push(Finding::of(UnknownTest::Smooth, model, (covariate, leg), (gain, rank), rank as f64));
            }
        }
    }
    found
}

/// A step at every value of each covariate that concerns a leg, on that leg.
pub(crate) fn jumps(model: &Model<'_>, covariates: &[Covariate]) -> Vec<Finding> {
    let mut found = Vec::new();
    let samples = model.table.samples();
    for leg in 0..model.table.joints.len() {
        let on_leg = model.joint_samples(leg);
        for covariate in covariates.iter().filter(|c| c.leg.is_none_or(|l| l == leg)) {
            let mut order: Vec<usize> = (0..samples).collect();
            order.sort_by(|a, b| covariate.values[*a].total_cmp(&covariate.values[*b]));
            for (at, gain) in on_leg.gains_from(&order).into_iter().enumerate().skip(FEW) {
                // Equal values stay together, and a few samples at either end are outliers and no step.
                if covariate.values[order[at]] == covariate.values[order[at - 1]] || at + FEW > samples {
                    continue;
                }
                if let Some(gain) = gain {
                    let jump = Finding::of(UnknownTest::Jump, model, (covariate, leg), (gain, 1), 1.0);
                    // The place is chosen among all samples.
                    found.push(Finding { worth: jump.worth - (samples as f64).ln(), ..jump });
                }
            }
        }
    }
    found
}

/// Sines in each covariate of waves, on each leg that it concerns, from one wave over the range to the sampling limit.
pub(crate) fn waves(model: &Model<'_>, covariates: &[Covariate]) -> Vec<Finding> {
    let samples = model.table.samples();
    let mut found = Vec::new();
    let count = samples.saturating_sub(2);
    for leg in 0..model.table.joints.len() {
        for covariate in covariates.iter().filter(|c| c.waves && c.leg.is_none_or(|l| l == leg)) {
            let x = covariate.scaled();
            // Cycles over the range in steps of one half.
            let cycles = |k: usize| 1.0 + 0.5 * k as f64;
            let mut functions = DMatrix::zeros(samples, 2 * count);
            for (row, x) in x.iter().enumerate() {
                // Half a cycle more turns the phase by the same angle each time.
                let (step, mut phase) = ((0.5 * PI * x).sin_cos(), (PI * x).sin_cos());
                for k in 0..count {
                    functions[(row, 2 * k)] = phase.0;
                    functions[(row, 2 * k + 1)] = phase.1;
                    phase = (phase.0 * step.1 + phase.1 * step.0, phase.1 * step.1 - phase.0 * step.0);
                }
            }
            let asked = model.joint_functions(leg, &functions);
            let (low, high) = covariate.range();
            for k in 0..count {
                let (gain, rank) = asked.ask(2 * k..2 * k + 2).gain();
                if rank > 0 {
                    // Sine, cosine and the period.
                    let wave = Finding::of(UnknownTest::Wave, model, (covariate, leg), (gain, rank), 3.0);
                    found.push(Finding { period: Some((high - low) / cycles(k)), ..wave });
                }
            }
        }
    }
    found
}

/// Residual along each leg, squared, and across it, over what the noise would give: `(Σ z²/(1 - h), number, the same
/// across)`.
fn scatter(model: &Model<'_>) -> Vec<(usize, f64)> {
    let table = model.table;
    let mut found = Vec::new();
    for leg in 0..table.joints.len() {
        let (mut along, mut dof_along, mut across, mut dof_across) = (0.0, 0.0, 0.0, 0.0);
        for (first, n) in &table.rows {
            let v = table.a.view((*first, table.joints.start + leg), (*n, 1)).into_owned();
            let length = v.norm();
            if *n < 2 || length == 0.0 {
                continue;
            }
            let d = v / length;
            let r = model.residual.rows(*first, *n);
            let q = model.leverage_rows(*first, *n);
            let z = d.column(0).dot(&r);
            let h = q.tr_mul(&d).norm_squared();
            along += z * z;
            dof_along += 1.0 - h;
            across += r.norm_squared() - z * z;
            dof_across += *n as f64 - 1.0 - (q.norm_squared() - h);
        }
        if dof_along > 5.0 && dof_across > 5.0 && across > 0.0 {
            let f = (along / dof_along) / (across / dof_across);
            found.push((leg, upper_f(f, dof_along, dof_across)));
        }
    }
    found
}

/// The most telling of what is left, or nothing.
pub(crate) fn remainder(model: &Model<'_>, covariates: &[Covariate]) -> Option<Unknown> {
    if model.is_rounding() {
        return None;
    }
    let smooths = smooths(model, covariates);
    let waves = waves(model, covariates);
    let mut findings = Vec::new();
    for (family, level) in [(smooths, SMOOTH), (waves, WAVE), (jumps(model, covariates), JUMP)] {
        let tests = family.len().max(1) as f64;
        let significant = family.into_iter().filter(|f| f.p_value * tests < level);
        findings.extend(significant.map(|f| Finding { p_value: (f.p_value * tests).min(1.0), ..f }));
    }
    findings.sort_by(|a, b| b.worth.total_cmp(&a.worth));
    let scattered = scatter(model);
    let worst = scattered.iter().min_by(|a, b| a.1.total_cmp(&b.1)).copied();
    let scatter = worst.filter(|(_, p)| p * (scattered.len() as f64) < SCATTER);
    if let Some(best) = findings.first() {
        let other = findings.iter().find(|f| f.covariate != best.covariate && f.worth > best.worth - 3.0);
        return Some(Unknown { runner_up: other.map(|f| f.covariate.clone()), ..best.unknown() });
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
pub(crate) fn rival(
    without: &Model<'_>,
    covariates: &[Covariate],
    worth_of_names: f64,
    margin: f64,
) -> Option<Unknown> {
    let mut all = smooths(without, covariates);
    // Steps in time have names.
    all.extend(jumps(without, covariates).into_iter().filter(|f| f.covariate != TIME && f.covariate != "row"));
    let tests = all.len();
    let best = all.into_iter().max_by(|a, b| a.worth.total_cmp(&b.worth))?;
    // What is not significant by itself withdraws nothing.
    let significant = best.p_value * (tests as f64) < SMOOTH;
    (significant && best.worth > worth_of_names + margin).then(|| best.unknown())
}
