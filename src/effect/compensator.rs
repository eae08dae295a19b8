//! Commands with which a mechanism with effects takes a pose.

use std::sync::Arc;

use super::{ActiveEffect, ActsOn, AvailableData, EffectContext, Environment, Extended, seen, to_be_seen_at};
use crate::conditions::{Conditions, Run};
use crate::mechanism::{GeometryError, KinematicsError, Mechanism, consistent};
use crate::pose::Pose;

/// Commands poses one after the other, the first one from home.
///
/// Effects on joints and geometry are compensated; play and backlash by the poses that were commanded before. Drifts and
/// steps describe one run and are not carried on. What only the instrument sees is compensated where the poses are asked
/// for as it sees them, and then sagging frames only.
#[derive(Debug)]
pub struct Compensator {
    model: Extended,
    instrument: Vec<ActiveEffect>,
    left_out: Vec<ActiveEffect>,
    /// True if an effect depends on all joints that were commanded before.
    remembers: bool,
    commanded: Vec<Vec<f64>>,
}

/// The answer for one pose.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Compensated {
    /// Joints to command.
    pub joints: Vec<f64>,
    /// The pose that the platform takes; of lower mobility it takes the wanted one as far as its joints control it.
    pub taken: Pose,
    /// The pose in the terms of the request: as the instrument sees it, or as it is.
    pub seen: Pose,
    /// Effects that did nothing, with what they need and the state has not.
    pub lacking: Vec<(String, Vec<String>)>,
    /// Covariates outside of the range on which an effect was fitted.
    pub outside: Vec<Extrapolated>,
}

/// A covariate outside of the range on which an effect was fitted, SI and °C.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Extrapolated {
    /// Name of the effect, with its place.
    pub effect: String,
    /// The covariate.
    pub covariate: String,
    /// Its value.
    pub value: f64,
    /// The range.
    pub range: [f64; 2],
}

/// Rounds in which joints and their own history settle; only a pose inside of a play needs more than a few.
const ROUNDS: usize = 1000;
/// Joints that change by less, m or rad, have settled.
const SETTLED: f64 = 1e-13;

impl Compensator {
    /// For a mechanism without effects and these effects. `as_seen` if poses are asked for as the instrument sees them.
    ///
    /// # Errors
    /// [`GeometryError`] if the mechanism cannot be copied.
    pub fn new(
        plain: &dyn Mechanism,
        environment: &Arc<Environment>,
        effects: &[ActiveEffect],
        as_seen: bool,
    ) -> Result<Self, GeometryError> {
        let (left_out, used): (Vec<ActiveEffect>, Vec<ActiveEffect>) = effects
            .iter()
            .cloned()
            .partition(|e| e.effect.describes_one_run() || (e.effect.acts_on() == ActsOn::Measurement && !as_seen));
        let (moving, instrument): (Vec<_>, Vec<_>) =
            used.into_iter().partition(|e| e.effect.acts_on() == ActsOn::Mechanism);
        let inner = plain.with_values(plain.values(), plain.home())?;
        let model = Extended::new(inner, Arc::clone(environment), moving);
        let context = EffectContext::new(model.inner(), environment);
        let needs_run = |e: &ActiveEffect| {
            let without = AvailableData { run: false, ..AvailableData::everything(&context, e.effect.as_ref(), &e.at) };
            !e.effect.missing(&context, &without).is_empty()
        };
        let remembers = model.effects().iter().any(needs_run);
        Ok(Self { model, instrument, left_out, remembers, commanded: Vec::new() })
    }

    /// The effects that are compensated.
    pub fn compensated(&self) -> impl Iterator<Item = &ActiveEffect> {
        self.model.effects().iter().chain(&self.instrument)
    }

    /// The effects that are not.
    pub fn left_out(&self) -> &[ActiveEffect] {
        &self.left_out
    }

    /// Joints to command for a pose in a state.
    ///
    /// # Errors
    /// [`KinematicsError`] if the pose has no joints.
    pub fn command(&mut self, wanted: &Pose, state: &Conditions) -> Result<Compensated, KinematicsError> {
        let environment = Arc::clone(self.model.environment());
        let context = EffectContext::new(self.model.inner(), &environment);
        let available = AvailableData::of_state(state);
        let mut lacking = Vec::new();
        let mut acts = |effect: &ActiveEffect| {
            let mut names = effect.lacking(&context, &available);
            if effect.at.lag.is_some() && state.run.is_none() {
                names.push("rows in the order of measurement".into());
            }
            let acts = names.is_empty();
            if !acts {
                lacking.push((effect.label(), names));
            }
            acts
        };
        // An effect with values of zero does nothing.
        let mut values = self.model.inner().values().to_vec();
        for effect in self.model.effects() {
            let factor = if acts(effect) { 1.0 } else { 0.0 };
            values.extend(effect.values.iter().map(|v| v * factor));
        }
        let instrument: Vec<ActiveEffect> = self.instrument.iter().filter(|e| acts(e)).cloned().collect();
        let home = context.home_joints().to_vec();
        let target = to_be_seen_at(&instrument, &context, &home, wanted, state);

        let mut at = state.clone();
        let row = self.commanded.len();
        at.previous_joints = Some(self.commanded.last().cloned().unwrap_or(home));
        let (mut taken, mut joints) = consistent(&self.model, &values, &target, &at)?;
        // What depends on the whole history depends on the command itself, which is its last row.
        let mut history = if self.remembers { self.commanded.clone() } else { Vec::new() };
        history.push(joints.clone());
        for _ in 0..if self.remembers { ROUNDS } else { 0 } {
            let recorded = state.run.as_ref().map(|run| Arc::clone(&run.history)).unwrap_or_default();
            at.run = Some(Run { row, part: 0.0, joints: history.clone().into(), history: recorded });
            (taken, joints) = consistent(&self.model, &values, &target, &at)?;
            let change = joints.iter().zip(&history[row]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            history[row].clone_from(&joints);
            // Also where a number is not finite.
            if !(change > SETTLED) {
                break;
            }
        }
        let seen = seen(&instrument, &context, &joints, &taken, state);
        let used = self.model.effects().iter().chain(&instrument);
        let active = used.filter(|e| lacking.iter().all(|(label, _)| *label != e.label()));
        let outside = active.flat_map(|e| {
            let named = |(covariate, value, range)| Extrapolated { effect: e.label(), covariate, value, range };
            e.outside_range(&at, &joints, &environment.condition_kinds).into_iter().map(named)
        });
        let answer = Compensated { outside: outside.collect(), joints: joints.clone(), taken, seen, lacking };
        self.commanded.push(joints);
        Ok(answer)
    }
}
