//! What is left when every name has been tried: tests of the residual that know no cause.
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

use super::model::Model;
use super::result::{NoiseVaries, Unknown};
use super::statistics::upper_f;
use crate::measurement::Dataset;

/// Levels of the families of tests.
const SMOOTH: f64 = 1e-3;
const WAVE: f64 = 1e-3;
const JUMP: f64 = 5e-4;
const SCATTER: f64 = 5e-4;
const SIZE: f64 = 2e-3;
const NOISE: f64 = 1e-3;
/// Samples on either side of a jump.
const FEW: usize = 3;
/// Degree of the polynomial.
const DEGREE: usize = 4;

/// A covariate of every sample.
#[derive(Clone, Debug)]
pub(super) struct Covariate {
    pub(super) name: String,
    /// The leg that it belongs to; `None` if it concerns all.
    leg: Option<usize>,
    values: Vec<f64>,
    /// True if waves in it are looked for.
    waves: bool,
}

impl Covariate {
    fn range(&self) -> (f64, f64) {
        self.values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)))
    }

    /// Scaled to -1 … 1.
    fn scaled(&self) -> Vec<f64> {
        let (low, high) = self.range();
        self.values.iter().map(|v| 2.0 * (v - low) / (high - low) - 1.0).collect()
    }
}

/// The recorded and derived covariates that change.
pub(super) fn covariates(data: &Dataset) -> Vec<Covariate> {
    let mut all: Vec<Covariate> = Vec::new();
    let mut add = |name: String, leg: Option<usize>, waves: bool, get: &dyn Fn(usize) -> Option<f64>| {
        let values: Option<Vec<f64>> = (0..data.len()).map(get).collect();
        if let Some(values) = values {
            let covariate = Covariate { name, leg, values, waves };
            let (low, high) = covariate.range();
            if high - low > 1e-9 * low.abs().max(high.abs()) {
                all.push(covariate);
            }
        }
    };
    let Some(first) = (!data.is_empty()).then(|| data.sample(0)) else { return all };
    let names: Vec<&String> = first.conditions.covariates.keys().collect();
    for name in &names {
        // Three components say what the elevation says; a column of units has said it before.
        let leg = name.strip_prefix("temp_leg").and_then(|n| n.parse::<usize>().ok()?.checked_sub(1));
        let waves = matches!(name.as_str(), "time" | "azimuth");
        add((*name).clone(), leg, waves, &|k| data.sample(k).conditions.get(name));
    }
    if !names.iter().any(|n| *n == "temp_legs") {
        add("temp_legs".into(), None, false, &|k| data.sample(k).conditions.leg_temperature());
    }
    if !names.iter().any(|n| *n == "time") {
        add("row".into(), None, true, &|k| Some(data.sample(k).row as f64));
    }
    for leg in 0..first.joints.len() {
        add(format!("length_leg{}", leg + 1), Some(leg), true, &|k| data.sample(k).joints.get(leg).copied());
        add(format!("travel_leg{}", leg + 1), Some(leg), false, &|k| {
            let s = data.sample(k);
            Some(s.joints.get(leg)? - s.conditions.previous_joints.as_ref()?.get(leg)?)
        });
    }
    all
}

/// One finding of a smooth or a wave.
#[derive(Clone, Debug)]
pub(super) struct Finding {
    covariate: String,
    leg: usize,
    p_value: f64,
    /// Half the change of BIC: what it gains over its price, nats.
    pub(super) worth: f64,
    period: Option<f64>,
    test: &'static str,
}

fn worth(model: &Model<'_>, gain: f64, parameters: f64) -> f64 {
    let noise = &model.noise;
    let fit = if noise.known { 0.5 * gain } else { -0.5 * noise.dof * (-(gain / noise.rss).min(1.0 - 1e-15)).ln_1p() };
    fit - 0.5 * parameters * noise.dof.ln()
}

/// Worth of the whole model over `without`, nats.
pub(super) fn worth_of(model: &Model<'_>, without: &Model<'_>, parameters: usize) -> f64 {
    worth(without, without.noise.rss - model.noise.rss, parameters as f64)
}

/// Polynomials of degree 1 to 4 in each covariate that concerns a leg, on that leg.
pub(super) fn smooths(model: &Model<'_>, covariates: &[Covariate]) -> Vec<Finding> {
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
                let p_value = model.noise.p_value(gain, rank);
                let worth = worth(model, gain, rank as f64);
                found.push(Finding {
                    covariate: covariate.name.clone(),
                    leg,
                    p_value,
                    worth,
                    period: None,
                    test: "smooth",
                });
            }
        }
    }
    found
}

/// A step at every value of each covariate that concerns a leg, on that leg.
pub(super) fn jumps(model: &Model<'_>, covariates: &[Covariate]) -> Vec<Finding> {
    let mut found = Vec::new();
    let samples = model.table.samples();
    for leg in 0..model.table.joints.len() {
        let on_leg = model.joint_functions(leg, &DMatrix::identity(samples, samples));
        for covariate in covariates.iter().filter(|c| c.leg.is_none_or(|l| l == leg)) {
            let mut order: Vec<usize> = (0..samples).collect();
            order.sort_by(|a, b| covariate.values[*a].total_cmp(&covariate.values[*b]));
            for (at, gain) in on_leg.gains_from(&order).into_iter().enumerate().skip(FEW) {
                // Equal values stay together, and a few samples at either end are outliers and no step.
                if covariate.values[order[at]] == covariate.values[order[at - 1]] || at + FEW > samples {
                    continue;
                }
                if let Some(gain) = gain {
                    let p_value = model.noise.p_value(gain, 1);
                    // The place is chosen among all samples.
                    let worth = worth(model, gain, 1.0) - (samples as f64).ln();
                    let name = covariate.name.clone();
                    found.push(Finding { covariate: name, leg, p_value, worth, period: None, test: "jump" });
                }
            }
        }
    }
    found
}

/// Sines in each covariate of waves, on each leg that it concerns, from one wave over the range to the sampling limit.
pub(super) fn waves(model: &Model<'_>, covariates: &[Covariate]) -> Vec<Finding> {
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
                    let p_value = model.noise.p_value(gain, rank);
                    let worth = worth(model, gain, 3.0);
                    let period = Some((high - low) / cycles(k));
                    found.push(Finding {
                        covariate: covariate.name.clone(),
                        leg,
                        p_value,
                        worth,
                        period,
                        test: "wave",
                    });
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
pub(super) fn remainder(model: &Model<'_>, covariates: &[Covariate]) -> Option<Unknown> {
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
        return Some(Unknown {
            covariate: Some(best.covariate.clone()),
            leg: Some(best.leg),
            test: best.test,
            p_value: best.p_value,
            period: best.period,
            runner_up: other.map(|f| f.covariate.clone()),
            withdrawn: Vec::new(),
        });
    }
    let blank = |leg, test, p_value| Unknown {
        covariate: None,
        leg,
        test,
        p_value,
        period: None,
        runner_up: None,
        withdrawn: Vec::new(),
    };
    if let Some((leg, p)) = scatter {
        return Some(blank(Some(leg), "scatter", p * scattered.len() as f64));
    }
    if model.noise.known {
        let p = ChiSquared::new(model.noise.dof).map_or(1.0, |d| d.sf(model.noise.rss));
        if p < SIZE {
            return Some(blank(None, "size", p));
        }
    }
    None
}

/// The unknown that explains more than all names together, if there is one: its worth beside no names against theirs.
pub(super) fn rival(
    without: &Model<'_>,
    covariates: &[Covariate],
    worth_of_names: f64,
    margin: f64,
) -> Option<Unknown> {
    let mut all = smooths(without, covariates);
    // Steps in time have names.
    all.extend(jumps(without, covariates).into_iter().filter(|f| f.covariate != "time" && f.covariate != "row"));
    let best = all.into_iter().max_by(|a, b| a.worth.total_cmp(&b.worth))?;
    (best.worth > worth_of_names + margin).then(|| Unknown {
        covariate: Some(best.covariate),
        leg: Some(best.leg),
        test: best.test,
        p_value: best.p_value,
        period: None,
        runner_up: None,
        withdrawn: Vec::new(),
    })
}

/// Does the size of the residual depend on a covariate, and which σ has each sample then, relative to the middle of the
/// range? Regression of `ln(d²)` on each, with `d²` the length squared of
/// a sample over what the noise would give.
pub(super) fn noise_varies(
    distances: &[Option<(f64, usize)>],
    covariates: &[Covariate],
    kept: &[usize],
) -> Option<(NoiseVaries, Vec<f64>)> {
    let mut best: Option<(f64, NoiseVaries, Vec<f64>)> = None;
    let tested: Vec<&Covariate> = covariates.iter().filter(|c| c.leg.is_none()).collect();
    for covariate in &tested {
        let x = covariate.scaled();
        let points: Vec<(f64, f64)> = kept
            .iter()
            .filter_map(|k| {
                distances[*k].filter(|(d, n)| *d > 0.0 && *n > 1).map(|(d, n)| (x[*k], (d / n as f64).ln()))
            })
            .collect();
        let n = points.len() as f64;
        if n < 12.0 {
            continue;
        }
        let (mx, my) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
        let (mut sxx, mut sxy, mut syy) = (0.0, 0.0, 0.0);
        for (x, y) in &points {
            sxx += (x - mx).powi(2);
            sxy += (x - mx) * (y - my);
            syy += (y - my).powi(2);
        }
        if !(sxx > 0.0) {
            continue;
        }
        let slope = sxy / sxx;
        let rest = (syy - slope * sxy).max(f64::MIN_POSITIVE) / (n - 2.0);
        let p_value = upper_f(slope * slope * sxx / rest, 1.0, n - 2.0) * tested.len() as f64;
        if p_value < NOISE && best.as_ref().is_none_or(|(p, ..)| p_value < *p) {
            // ln σ² changes by 2 slopes over the range.
            let spreads = x.iter().map(|x| (0.5 * slope * x).exp()).collect();
            best = Some((
                p_value,
                NoiseVaries { covariate: covariate.name.clone(), ratio: slope.exp(), p_value },
                spreads,
            ));
        }
    }
    best.map(|(_, found, spreads)| (found, spreads))
}

/// Correlation of the residual of each sample with that of the sample before, and whether it is more than chance.
pub(super) fn correlation(model: &Model<'_>, left_out: &[usize]) -> Option<f64> {
    let table = model.table;
    let (mut product, mut square, mut count) = (0.0, 0.0, 0.0);
    let kept = |k: usize| !left_out.contains(&k);
    for k in 1..table.samples() {
        let ((a, n), (b, m)) = (table.rows[k - 1], table.rows[k]);
        if n == m && n > 0 && kept(k) && kept(k - 1) {
            let (before, now) = (model.residual.rows(a, n), model.residual.rows(b, m));
            product += before.dot(&now);
            square += 0.5 * (before.norm_squared() + now.norm_squared());
            count += n as f64;
        }
    }
    // Four σ, and rows enough that this means something.
    let rho = if square > 0.0 { product / square } else { 0.0 };
    (count > 30.0 && rho * f64::sqrt(count) > 4.0).then_some(rho.min(0.95))
}
