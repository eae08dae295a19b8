//! Effects that could not be tested because a sensor is missing, and that would look like a named one.
//!
//! What a missing sensor would have read is not known, so that the effect is given whatever it needs: an amplitude of its
//! own in each sample. If it then explains what the named effect explains, it is not excluded. A temperature changes slowly,
//! so that amplitudes of a thermal effect that jump from row to row exclude it after all.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use crate::conditions::{ConditionTable, Conditions, Extent, PAYLOAD};
use crate::diagnosis::answer::result::NotTestable;
use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::design_matrix::Block;
use crate::diagnosis::linear::hypotheses::Hypotheses;
use crate::diagnosis::linear::model::Model;
use crate::diagnosis::linear::normal_equations::inverse_factor;
use crate::diagnosis::search::iteration::SearchState;
use crate::diagnosis::search::stepwise::{Score, TOLD_APART};
use crate::effect::{AvailableData, Catalogue, Effect, Environment};

/// Correlation of the amplitudes of neighbouring rows below which they are those of no temperature.
const SLOW: f64 = 0.25;
/// Standard deviations of the gain of free amplitudes by chance.
const CHANCE: f64 = 2.0;

/// The effects whose sensors are missing, per unit of what they would have read.
pub(crate) struct Unseen {
    effects: Vec<UnseenEffect>,
}

struct UnseenEffect {
    name: String,
    /// True if it follows a temperature.
    slow: bool,
    /// Whitened motion of the readings per unit, in the rows of the table.
    column: DVector<f64>,
}

impl Unseen {
    /// Those of `missing` that lack columns of temperatures or of the payload alone, at the point where a search ended.
    pub(crate) fn new(
        subject: &Hypotheses<'_>,
        state: &SearchState,
        catalogue: &Catalogue,
        missing: &[NotTestable],
    ) -> Result<Self, DiagnoseError> {
        let kinds = &subject.environment.condition_kinds;
        let is_sensor = |name: &String| kinds.is_temperature(name) || name == PAYLOAD;
        let joints = subject.mechanism.joints().len();
        // Of the legs all sensors are missing or none: a single one has no course of its own.
        let all_or_one = |m: &NotTestable| m.missing.len() == 1 || m.missing.len() == joints;
        // Where their mean was recorded the legs have no course that is not known.
        let available = AvailableData::of(subject.data);
        let has_mean = |name: &String| {
            let kind = kinds.of(name).filter(|kind| kind.extent == Extent::EachLeg);
            kind.is_some_and(|kind| available.has(&kind.of_all_legs()))
        };
        let is_lacking =
            |m: &&NotTestable| m.missing.iter().all(is_sensor) && all_or_one(m) && !m.missing.iter().all(has_mean);
        let lacking: Vec<&NotTestable> = missing.iter().filter(is_lacking).collect();
        if lacking.is_empty() || state.names().is_empty() {
            return Ok(Self { effects: Vec::new() });
        }
        let sensors: Vec<&String> = lacking.iter().flat_map(|m| &m.missing).collect();
        let environment = Arc::new(with_references(&subject.environment, &sensors));
        let data = subject.data.with_conditions(|conditions| with_readings(conditions, &sensors, &environment));
        let effects: Catalogue = lacking.iter().filter_map(|m| catalogue.get(&m.effect)).cloned().collect();
        let (asked, _) = Hypotheses::new(subject.mechanism, &data, environment, subject.prior.clone(), &effects, &[]);
        let table = asked.table(&state.point, &state.spreads)?;
        let mut effects = Vec::new();
        for group in asked.groups.iter().filter(|g| g.parameters.len() == 1) {
            for place in &group.places {
                let slow = needs_temperature(group.effect.as_ref(), &lacking, kinds);
                let column = table.columns(&Block { columns: place.columns.clone(), first: 0 }).column(0).into_owned();
                effects.push(UnseenEffect { name: group.effect.name().to_owned(), slow, column });
            }
        }
        Ok(Self { effects })
    }

    /// The names that explain what `named` explains beside the model `without`. A jump is no temperature.
    pub(crate) fn alike(
        &self,
        without: &Model,
        subject: &Hypotheses<'_>,
        named: &Score,
        weight: f64,
    ) -> Result<Vec<String>, DiagnoseError> {
        let mut names: Vec<String> = Vec::new();
        let variance = without.noise.variance_after(named.gain, named.rank as f64);
        for effect in &self.effects {
            let jumps = named.candidate.from.is_some();
            if names.contains(&effect.name) || (effect.slow && jumps) {
                continue;
            }
            let Some((gain, course)) = effect.freely(without, subject, weight)? else { continue };
            let free = course.len() as f64;
            // Of its gain one part in each amplitude is chance.
            let own = gain - free * variance;
            let as_much = named.gain - own < (CHANCE * (2.0 * free).sqrt() + TOLD_APART) * variance;
            if as_much && (!effect.slow || correlation(&course) > SLOW) {
                names.push(effect.name.clone());
            }
        }
        Ok(names)
    }
}

impl UnseenEffect {
    /// What the effect gains beside a model with an amplitude of its own in each sample, and these amplitudes; `None` if it
    /// moves no reading.
    fn freely(
        &self,
        without: &Model,
        subject: &Hypotheses<'_>,
        weight: f64,
    ) -> Result<Option<(f64, Vec<f64>)>, DiagnoseError> {
        let (kept, table) = (&without.kept, without.table());
        let nuisance = Block { columns: 0..table.nuisance, first: 0 };
        let others = without.candidates.iter().map(|name| name.block(&subject.groups, table));
        let parts: Vec<DMatrix<f64>> = std::iter::once(nuisance).chain(others).map(|b| kept.columns(&b)).collect();
        let width = parts.iter().map(DMatrix::ncols).sum();
        let mut z = DMatrix::zeros(kept.r.len(), width);
        let mut at = 0;
        for part in &parts {
            z.columns_mut(at, part.ncols()).copy_from(part);
            at += part.ncols();
        }
        let (mut across, mut r) = (z.clone(), kept.r.clone());
        let mut samples = Vec::new();
        for (first, n) in kept.rows() {
            let d = self.column.rows(first, n);
            let square = d.norm_squared();
            if square > 0.0 {
                let along = across.rows(first, n).tr_mul(&d) / square;
                across.rows_mut(first, n).ger(-1.0, &d, &along, 1.0);
                let along = d.dot(&r.rows(first, n)) / square;
                r.rows_mut(first, n).axpy(-along, &d, 1.0);
                samples.push((first, n, square));
            }
        }
        if samples.is_empty() {
            return Ok(None);
        }
        let inverse = inverse_factor(across.tr_mul(&across), &(&table.precision * weight))?;
        let mut moment = across.tr_mul(&r);
        let mut corner = moment.rows_mut(0, table.nuisance);
        corner += &table.gradient * weight;
        let t = &inverse * moment;
        let left = (r.norm_squared() + table.penalty * weight - t.norm_squared()) / without.inflation();
        let residual = &kept.r - &z * inverse.tr_mul(&t);
        let amplitude = |(first, n, square): &(usize, usize, f64)| {
            self.column.rows(*first, *n).dot(&residual.rows(*first, *n)) / square
        };
        Ok(Some((without.noise.objective - left, samples.iter().map(amplitude).collect())))
    }
}

/// True if the effect lacks a temperature.
fn needs_temperature(effect: &dyn Effect, lacking: &[&NotTestable], kinds: &ConditionTable) -> bool {
    let own = lacking.iter().filter(|m| m.effect == effect.name()).flat_map(|m| &m.missing);
    own.into_iter().any(|name| kinds.is_temperature(name))
}

/// References from which the readings of [`with_readings`] differ by one unit.
fn with_references(environment: &Environment, sensors: &[&String]) -> Environment {
    let mut with = environment.clone();
    for name in sensors.iter().filter(|name| environment.condition_kinds.is_temperature(name)) {
        with.references.insert((*name).clone(), 0.0);
    }
    with
}

/// Conditions with one kelvin above the reference, or one kilogram, in each sensor.
fn with_readings(conditions: &Conditions, sensors: &[&String], environment: &Environment) -> Conditions {
    let mut with = conditions.clone();
    for name in sensors {
        let from = environment.reference(name).unwrap_or(0.0);
        with.covariates.insert((*name).clone(), from + 1.0);
    }
    with
}

/// Correlation of each value with the next.
fn correlation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let off: Vec<f64> = values.iter().map(|v| v - mean).collect();
    let square: f64 = off.iter().map(|v| v * v).sum();
    off.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / square.max(f64::MIN_POSITIVE)
}
