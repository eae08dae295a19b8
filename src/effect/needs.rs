//! Data that an effect needs to act, and the range over which it was fitted.

use std::collections::BTreeMap;

use super::{ActiveEffect, AvailableData, EffectContext, ScanPoint};
use crate::conditions::Conditions;
use crate::measurement::Dataset;

impl AvailableData {
    /// Everything that effects ask for: what they still miss is missing in the mechanism file.
    pub fn everything(context: &EffectContext<'_>, at: &ScanPoint) -> Self {
        let legs = (0..context.joints()).map(EffectContext::leg_temperature);
        let known = ["temp_legs", "temp_platform", "temp_base", "payload"].map(String::from);
        let sensors = context.environment.sensors.iter().map(|s| s.covariate.clone());
        let covariates = legs.chain(known).chain(sensors).chain(at.covariate.clone()).collect();
        Self { covariates, gravity: true, run: true, moves: all_moves(), samples: usize::MAX }
    }

    /// The data of one state; the history of the joints is taken as known.
    pub fn of_state(state: &Conditions) -> Self {
        let covariates = state.covariates.keys().cloned().collect();
        Self { covariates, gravity: state.gravity.is_some(), run: true, moves: all_moves(), samples: 1 }
    }
}

/// Short and long moves, m or rad.
fn all_moves() -> Vec<f64> {
    vec![1e-6, 1.0]
}

fn is_temperature(name: &str) -> bool {
    name.starts_with("temp_")
}

impl ActiveEffect {
    /// Data that the effect needs to act and that `available` lacks.
    pub fn lacking(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        let own = self.own_temperatures();
        if own.is_empty() {
            return self.effect.missing(context, available);
        }
        // At one place of its scan it needs the temperatures of that place only.
        own.into_iter().filter(|name| !available.has(name)).collect()
    }

    /// The temperatures of which it takes the difference from a reference.
    pub fn temperatures(&self, context: &EffectContext<'_>) -> Vec<String> {
        let own = self.own_temperatures();
        if !own.is_empty() {
            return own;
        }
        let mut names = self.effect.missing(context, &AvailableData::default());
        names.retain(|name| is_temperature(name));
        names
    }

    /// Temperatures of the place of its scan.
    fn own_temperatures(&self) -> Vec<String> {
        if self.at.leg.is_none() && self.at.covariate.is_none() {
            return Vec::new();
        }
        self.effect.covariates(&self.at).into_iter().filter(|name| is_temperature(name)).collect()
    }

    /// Smallest and largest value of each covariate that it depends on, over samples.
    pub fn range_over(&self, data: &Dataset) -> BTreeMap<String, [f64; 2]> {
        let mut ranges = BTreeMap::new();
        for name in self.effect.covariates(&self.at) {
            let values = data.iter().filter_map(|s| covariate(&name, &s.conditions, &s.joints));
            let found = values.fold(None, |range: Option<[f64; 2]>, v| {
                Some(range.map_or([v, v], |[low, high]| [low.min(v), high.max(v)]))
            });
            ranges.extend(found.map(|range| (name, range)));
        }
        ranges
    }

    /// The covariates of a state that lie outside of the range in which it was fitted, with their value and that range.
    pub fn outside_range(&self, state: &Conditions, joints: &[f64]) -> Vec<(String, f64, [f64; 2])> {
        let outside = |(name, range): (&String, &[f64; 2])| {
            let value = covariate(name, state, joints)?;
            (value < range[0] || value > range[1]).then(|| (name.clone(), value, *range))
        };
        self.range.iter().filter_map(outside).collect()
    }
}

/// The value of a recorded or a derived covariate.
fn covariate(name: &str, state: &Conditions, joints: &[f64]) -> Option<f64> {
    let of_leg = |stem: &str| {
        let leg: usize = name.strip_prefix(stem)?.parse().ok()?;
        let now = joints.get(leg.checked_sub(1)?)?;
        let before = || state.previous_joints.as_ref()?.get(leg - 1);
        Some((*now, before().copied()))
    };
    if name == "temp_legs" {
        return state.leg_temperature();
    }
    if let Some((now, _)) = of_leg("length_leg") {
        return Some(now);
    }
    if let Some((now, before)) = of_leg("travel_leg") {
        return Some(now - before?);
    }
    if let Some((now, before)) = of_leg("approach_leg") {
        return Some((now - before?).signum());
    }
    state.get(name)
}
