//! Data that an effect needs to act, and the range over which it was fitted.

use std::collections::BTreeMap;

use super::{ActiveEffect, AvailableData, Effect, EffectContext, ScanPoint};
use crate::conditions::{ConditionKind, ConditionTable, Conditions, Extent, TIME, of_leg};
use crate::measurement::Dataset;

impl AvailableData {
    /// Every condition of the table and whatever else an effect names at a place of its scan: what it still misses is
    /// missing in the mechanism file.
    pub fn everything(context: &EffectContext<'_>, effect: &dyn Effect, at: &ScanPoint) -> Self {
        let known = context.environment.condition_kinds.recorded(context.joints());
        let sensors = context.environment.sensors.iter().map(|s| s.covariate.clone());
        let own = at.covariate.clone().into_iter().chain(effect.covariates(at));
        let covariates = known.chain(sensors).chain(own).collect();
        Self { covariates, gravity: true, run: true, moves: all_moves(), samples: usize::MAX, heights_only: false }
    }

    /// The data of one state; the history of the joints is taken as known.
    pub fn of_state(state: &Conditions) -> Self {
        let covariates = state.covariates.keys().cloned().collect();
        Self {
            covariates,
            gravity: state.gravity.is_some(),
            run: true,
            moves: all_moves(),
            samples: 1,
            heights_only: false,
        }
    }
}

/// True for a recorded covariate, and for the mean of legs that are all recorded.
fn is_known(name: &str, context: &EffectContext<'_>, available: &AvailableData) -> bool {
    let kinds = &context.environment.condition_kinds;
    let mean = kinds.of(name).filter(|kind| kind.extent == Extent::EachLeg && kind.of_all_legs() == name);
    let of_all = |kind: &ConditionKind| (0..context.joints()).all(|leg| available.has(&of_leg(&kind.name, leg)));
    available.has(name) || mean.is_some_and(of_all)
}

/// Short and long moves, m or rad.
fn all_moves() -> Vec<f64> {
    vec![1e-6, 1.0]
}

impl ActiveEffect {
    /// Data that the effect needs to act and that `available` lacks.
    pub fn lacking(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        let own = self.own_temperatures(context);
        let mut lacking = match own.is_empty() {
            true => self.effect.missing(context, available),
            // At one place of its scan it needs the temperatures of that place only.
            false => own.into_iter().filter(|name| !is_known(name, context, available)).collect(),
        };
        if self.at.lag.is_some() && !(available.run && available.has(TIME)) {
            lacking.push(TIME.into());
        }
        lacking
    }

    /// The temperatures of which it takes the difference from a reference.
    pub fn temperatures(&self, context: &EffectContext<'_>) -> Vec<String> {
        let own = self.own_temperatures(context);
        if !own.is_empty() {
            return own;
        }
        let mut names = self.effect.missing(context, &AvailableData::default());
        names.retain(|name| context.environment.condition_kinds.is_temperature(name));
        names
    }

    /// Temperatures of the place of its scan.
    fn own_temperatures(&self, context: &EffectContext<'_>) -> Vec<String> {
        if self.at.leg.is_none() && self.at.covariate.is_none() {
            return Vec::new();
        }
        let kinds = &context.environment.condition_kinds;
        self.effect.covariates(&self.at).into_iter().filter(|name| kinds.is_temperature(name)).collect()
    }

    /// Smallest and largest value of each covariate that it depends on, over samples.
    pub fn range_over(&self, data: &Dataset, kinds: &ConditionTable) -> BTreeMap<String, [f64; 2]> {
        let mut ranges = BTreeMap::new();
        for name in self.effect.covariates(&self.at) {
            let values = data.iter().filter_map(|s| kinds.value(&name, &s.conditions, &s.joints));
            let found = values.fold(None, |range: Option<[f64; 2]>, v| {
                Some(range.map_or([v, v], |[low, high]| [low.min(v), high.max(v)]))
            });
            ranges.extend(found.map(|range| (name, range)));
        }
        ranges
    }

    /// The covariates of a state that lie outside of the range in which it was fitted, with their value and that range.
    pub fn outside_range(
        &self,
        state: &Conditions,
        joints: &[f64],
        kinds: &ConditionTable,
    ) -> Vec<(String, f64, [f64; 2])> {
        let outside = |(name, range): (&String, &[f64; 2])| {
            let value = kinds.value(name, state, joints)?;
            (value < range[0] || value > range[1]).then(|| (name.clone(), value, *range))
        };
        self.range.iter().filter_map(outside).collect()
    }
}
