//! Tests of one covariate at one place: the polynomials, steps and sines of [`remainder`](super::remainder).

use std::f64::consts::PI;

use nalgebra::DMatrix;

use crate::diagnosis::answer::unknown::UnknownTest;
use crate::diagnosis::linear::model::Model;
use crate::diagnosis::linear::place_functions::PlaceSamples;
use crate::diagnosis::linear::unit_motion::Place;
use crate::diagnosis::search::covariates::{Covariate, DEGREE};

/// Samples on either side of a jump.
pub(super) const FEW: usize = 3;
/// Most waves of one covariate: from one to about 256 cycles over its range. Each is a pass over all samples, so that all
/// of them up to the sampling limit would cost the square of the samples.
const MOST_WAVES: usize = 512;
/// Waves that are multiplied at once, and samples: what stays in the cache of a core.
const WAVES_AT_ONCE: usize = 32;
const SAMPLES_AT_ONCE: usize = 256;

/// One finding of a smooth, a jump or a wave.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Finding<'a> {
    pub(crate) covariate: &'a Covariate,
    pub(crate) place: Place,
    pub(crate) gain: f64,
    /// Columns that the gain is of.
    pub(crate) rank: usize,
    /// Half the change of BIC: what it gains over its price, nats.
    pub(crate) worth: f64,
    pub(crate) period: Option<f64>,
    /// The value of the covariate at a jump.
    pub(crate) from: Option<f64>,
    pub(crate) test: UnknownTest,
}

impl<'a> Finding<'a> {
    /// What a test of a covariate at a place found: a gain from `rank` columns, at the price of so many parameters.
    fn of(
        test: UnknownTest,
        model: &Model,
        (covariate, place): (&'a Covariate, Place),
        (gain, rank): (f64, usize),
        price: f64,
    ) -> Self {
        Self { covariate, place, gain, rank, worth: worth(model, gain, price), period: None, from: None, test }
    }

    /// Its probability by chance as one of so many tests, if that is below a level. The level is far below one hundredth.
    pub(crate) fn significant(&self, model: &Model, tests: f64, level: f64) -> Option<f64> {
        let noise = &model.noise;
        let p = noise.may_be_significant(self.gain, self.rank).then(|| noise.p_value(self.gain, self.rank) * tests)?;
        (p < level).then_some(p)
    }
}

/// Half the change of BIC by a gain at the price of so many parameters, nats.
pub(crate) fn worth(model: &Model, gain: f64, parameters: f64) -> f64 {
    let noise = &model.noise;
    let fit =
        if noise.known { 0.5 * gain } else { -0.5 * noise.dof * (-(gain / noise.objective).min(1.0 - 1e-15)).ln_1p() };
    fit - 0.5 * parameters * noise.dof.ln()
}

/// A covariate with what the tests of each place ask of it.
pub(crate) struct Prepared<'a> {
    covariate: &'a Covariate,
    /// Its values from -1 to 1.
    scaled: Vec<f64>,
    /// The samples by its values.
    order: Vec<usize>,
}

impl<'a> Prepared<'a> {
    pub(crate) fn all(covariates: &'a [Covariate]) -> Vec<Self> {
        let of = |covariate: &'a Covariate| {
            let values = &covariate.values;
            let mut order: Vec<usize> = (0..values.len()).collect();
            order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
            Self { covariate, scaled: covariate.scaled(), order }
        };
        covariates.iter().map(of).collect()
    }

    /// True if the covariate may act at a place: what belongs to a leg acts there alone.
    fn concerns(&self, place: Place) -> bool {
        self.covariate.own.is_none_or(|own| place == own)
    }
}

/// Legendre polynomials of a value from -1 to 1, from the first degree on.
pub(crate) fn legendre(x: f64) -> [f64; DEGREE] {
    [x, 1.5 * x * x - 0.5, (2.5 * x * x - 1.5) * x, (4.375 * x * x - 3.75) * x * x + 0.375]
}

/// Polynomials of degree 1 to 4 in each covariate that concerns a place, at that place.
pub(crate) fn smooths<'a>(
    model: &Model,
    (place, samples): (Place, &PlaceSamples),
    covariates: &[Prepared<'a>],
    found: &mut Vec<Finding<'a>>,
) {
    for degree in (1..=DEGREE).rev() {
        let mine: Vec<&Prepared<'a>> =
            covariates.iter().filter(|c| c.concerns(place) && c.covariate.asked.degree == degree).collect();
        let mut functions = DMatrix::zeros(model.table().samples(), degree * mine.len());
        for (m, covariate) in mine.iter().enumerate() {
            for (row, x) in covariate.scaled.iter().enumerate() {
                for (d, value) in legendre(*x).into_iter().take(degree).enumerate() {
                    functions[(row, degree * m + d)] = value;
                }
            }
        }
        for (c, asked) in mine.iter().zip(samples.ask(&functions, degree)) {
            let (gain, rank) = asked.gain();
            if rank > 0 {
                found.push(Finding::of(UnknownTest::Smooth, model, (c.covariate, place), (gain, rank), rank as f64));
            }
        }
    }
}

/// A step at every value of each covariate that concerns a place, at that place.
pub(crate) fn jumps<'a>(
    model: &Model,
    (place, here): (Place, &PlaceSamples),
    covariates: &[Prepared<'a>],
    found: &mut Vec<Finding<'a>>,
) {
    for c in covariates.iter().filter(|c| c.concerns(place) && c.covariate.asked.jumps) {
        let values = &c.covariate.values;
        let order: Vec<usize> = c.order.iter().copied().filter(|k| !model.kept.is_out(*k)).collect();
        for (at, gain) in here.gains_from(&order).into_iter().enumerate().skip(FEW) {
            // Equal values stay together, and a few samples at either end are outliers and no step.
            if values[order[at]] == values[order[at - 1]] || at + FEW > order.len() {
                continue;
            }
            if let Some(gain) = gain {
                let jump = Finding::of(UnknownTest::Jump, model, (c.covariate, place), (gain, 1), 1.0);
                // The place is chosen among all samples.
                let from = Some(0.5 * (values[order[at - 1]] + values[order[at]]));
                found.push(Finding { worth: jump.worth - (order.len() as f64).ln(), from, ..jump });
            }
        }
    }
}

/// Sines in each covariate of waves, at a place that it concerns, from one wave over the range to the sampling limit, in
/// steps of one half; no more than [`MOST_WAVES`].
pub(crate) fn waves<'a>(
    model: &Model,
    (place, here): (Place, &PlaceSamples),
    covariates: &[Prepared<'a>],
    found: &mut Vec<Finding<'a>>,
) {
    let samples = model.table().samples();
    let count = samples.saturating_sub(2).min(MOST_WAVES);
    for c in covariates.iter().filter(|c| c.covariate.asked.waves && c.concerns(place)) {
        let mut sums = here.pairs(count);
        for (part, x) in c.scaled.chunks(SAMPLES_AT_ONCE).enumerate() {
            // Half a cycle more turns the phase by the same angle each time.
            let turn: Vec<(f64, f64)> = x.iter().map(|x| (0.5 * PI * x).sin_cos()).collect();
            let mut phase: Vec<(f64, f64)> = x.iter().map(|x| (PI * x).sin_cos()).collect();
            for first in (0..count).step_by(WAVES_AT_ONCE) {
                let mut functions = DMatrix::zeros(x.len(), 2 * WAVES_AT_ONCE.min(count - first));
                for pair in functions.as_mut_slice().chunks_exact_mut(2 * x.len()) {
                    let (sines, cosines) = pair.split_at_mut(x.len());
                    for (((sine, cosine), phase), step) in sines.iter_mut().zip(cosines).zip(&mut phase).zip(&turn) {
                        (*sine, *cosine) = *phase;
                        *phase = (phase.0 * step.1 + phase.1 * step.0, phase.1 * step.1 - phase.0 * step.0);
                    }
                }
                here.add(&mut sums, part * SAMPLES_AT_ONCE, first, &functions);
            }
        }
        let (low, high) = c.covariate.range();
        for (k, (gain, rank)) in here.gains_of_pairs(&sums).into_iter().enumerate() {
            if rank > 0 {
                // Sine, cosine and the period.
                let wave = Finding::of(UnknownTest::Wave, model, (c.covariate, place), (gain, rank), 3.0);
                let cycles = 1.0 + 0.5 * k as f64;
                found.push(Finding { period: Some((high - low) / cycles), ..wave });
            }
        }
    }
}
