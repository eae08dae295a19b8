//! Context of effects: the machine, the recorded data, and the current sample.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use nalgebra::{Matrix6xX, Vector3};

use super::ScanPoint;
use crate::conditions::{ConditionKind, ConditionTable, Conditions, Extent, TIME};
use crate::measurement::Dataset;
use crate::mechanism::{Body, Mechanism, ParameterRole};
use crate::pose::{Pose, PoseConvention};
use crate::units::Dimension;

/// A temperature sensor at a known place of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// The covariate that holds its readings, such as `temp_base1`.
    pub covariate: String,
    /// The body that it sits on.
    pub body: Body,
    /// Where, in the frame of that body, m.
    pub place: Vector3<f64>,
}

/// Surroundings of the mechanism as its file states them, SI.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Environment {
    /// What the covariates of its data mean.
    pub condition_kinds: ConditionTable,
    /// How its files write poses.
    pub convention: PoseConvention,
    /// Temperature at which the geometry holds, °C.
    pub reference_temperature: Option<f64>,
    /// Reference temperatures of single covariates where no common one is stated, °C: the means of the run.
    pub references: BTreeMap<String, f64>,
    /// Mass of the platform, kg.
    pub mass: Option<f64>,
    /// Its centre of mass, platform frame, m.
    pub centre_of_mass: Option<Vector3<f64>>,
    /// Centre of the payload, platform frame, m.
    pub payload_centre: Option<Vector3<f64>>,
    /// Pitch of the screws, m.
    pub screw_pitch: Option<f64>,
    /// Temperature sensors whose places are known.
    pub sensors: Vec<Sensor>,
    /// The pose at home of the drawing, from which effects measure; that of the mechanism itself if absent. A calibrated
    /// mechanism has another one, but its effects were fitted with this.
    pub home: Option<Pose>,
    /// The joints that are commanded for home, likewise.
    pub home_joints: Option<Vec<f64>>,
    /// Directions of the legs at home, base frame, likewise ([`EffectContext::home_legs`]).
    pub home_legs: Option<Vec<Option<Vector3<f64>>>>,
}

impl Environment {
    /// This environment with the mean of every temperature of a run as its reference where none is stated.
    #[must_use]
    pub fn with_references_of(&self, data: &Dataset) -> Self {
        self.with_references_among(data.iter().map(|s| &s.conditions))
    }

    /// This environment with the means over the states of a list as references where none are stated.
    #[must_use]
    pub fn with_references_among<'a>(&self, states: impl Iterator<Item = &'a Conditions>) -> Self {
        let kinds = &self.condition_kinds;
        let of_legs: Vec<&ConditionKind> =
            kinds.iter().filter(|k| k.is_temperature() && k.extent == Extent::EachLeg).collect();
        let mut sums: BTreeMap<String, (f64, f64)> = BTreeMap::new();
        let mut add = |name: String, value: f64| {
            let sum = sums.entry(name).or_default();
            *sum = (sum.0 + value, sum.1 + 1.0);
        };
        for state in states {
            let means = of_legs.iter().filter_map(|kind| Some((kind.of_all_legs(), state.mean_of_legs(&kind.name)?)));
            let means: BTreeMap<String, f64> = means.collect();
            let recorded = state.covariates.iter().filter(|(name, _)| kinds.is_temperature(name));
            for (name, value) in recorded.filter(|(name, _)| !means.contains_key(*name)) {
                add(name.clone(), *value);
            }
            means.into_iter().for_each(|(name, mean)| add(name, mean));
        }
        let mut with = self.clone();
        for (name, (sum, count)) in sums {
            with.references.entry(name).or_insert(sum / count);
        }
        with
    }

    /// The temperature of a covariate at which the geometry holds, °C, if one is stated.
    pub fn reference(&self, covariate: &str) -> Option<f64> {
        self.reference_temperature.or_else(|| self.references.get(covariate).copied())
    }

    /// Difference of a temperature of a covariate from its reference.
    fn difference(&self, covariate: &str, temperature: f64) -> f64 {
        temperature - self.reference(covariate).unwrap_or(temperature)
    }
}

/// Data recorded with the samples.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct AvailableData {
    /// Covariates that every sample has.
    pub covariates: BTreeSet<String>,
    /// True if the direction of gravity is known for every sample.
    pub gravity: bool,
    /// True if the samples are in a run, in the order of measuring.
    pub run: bool,
    /// Lengths of the moves of all joints from one sample to the next, in their units, in order of size.
    pub moves: Vec<f64>,
    /// Number of samples.
    pub samples: usize,
    /// True if nothing but heights over a plane was measured.
    pub heights_only: bool,
}

impl AvailableData {
    /// The data that every sample of `data` has.
    pub fn of(data: &Dataset) -> Self {
        let mut samples = data.iter();
        let Some(first) = samples.next() else { return Self::default() };
        let mut covariates: BTreeSet<String> = first.conditions.covariates.keys().cloned().collect();
        for sample in samples {
            covariates.retain(|name| sample.conditions.covariates.contains_key(name));
        }
        let mut moves = Vec::new();
        for sample in data.iter() {
            let before = sample.conditions.previous_joints.iter().flatten();
            moves.extend(sample.joints.iter().zip(before).map(|(now, before)| (now - before).abs()));
        }
        moves.sort_by(f64::total_cmp);
        Self {
            covariates,
            gravity: data.iter().all(|s| s.conditions.gravity.is_some()),
            run: data.iter().all(|s| s.conditions.run.is_some()),
            moves,
            samples: data.len(),
            heights_only: data.heights_only(),
        }
    }

    /// Part of the moves that are shorter than a length.
    pub fn shorter_moves(&self, length: f64) -> f64 {
        self.moves.iter().take_while(|m| **m < length).count() as f64 / self.moves.len().max(1) as f64
    }

    /// True if every sample has the covariate.
    pub fn has(&self, covariate: &str) -> bool {
        self.covariates.contains(covariate)
    }

    /// The covariates that are temperatures, by name.
    pub fn temperatures(&self, kinds: &ConditionTable) -> Vec<String> {
        self.covariates.iter().filter(|name| kinds.is_temperature(name)).cloned().collect()
    }
}

/// The machine that effects act on.
#[derive(Clone, Debug)]
pub struct EffectContext<'a> {
    /// The mechanism without effects.
    pub mechanism: &'a dyn Mechanism,
    /// Surroundings of the mechanism.
    pub environment: &'a Environment,
    home: Home,
}

/// Reference of the effects: the mechanism at home.
#[derive(Clone, Debug)]
pub(super) struct Home {
    joints: Arc<[f64]>,
    legs: Arc<[Option<Vector3<f64>>]>,
}

impl Home {
    pub(super) fn of(mechanism: &dyn Mechanism, environment: &Environment) -> Self {
        let n = mechanism.joints().len();
        let own = || mechanism.inverse(mechanism.values(), &mechanism.home(), &Conditions::unknown());
        let joints = match &environment.home_joints {
            Some(stated) if stated.len() == n => stated.clone(),
            _ => own().unwrap_or_else(|_| vec![0.0; n]),
        };
        let legs = match &environment.home_legs {
            Some(stated) if stated.len() == n => stated.clone(),
            _ => leg_directions(mechanism, mechanism.values(), &mechanism.home()),
        };
        Self { joints: joints.into(), legs: legs.into() }
    }
}

impl<'a> EffectContext<'a> {
    /// A mechanism and what stands around it.
    pub fn new(mechanism: &'a dyn Mechanism, environment: &'a Environment) -> Self {
        Self::with_home(mechanism, environment, Home::of(mechanism, environment))
    }

    pub(super) fn with_home(mechanism: &'a dyn Mechanism, environment: &'a Environment, home: Home) -> Self {
        Self { mechanism, environment, home }
    }

    /// Joints at home.
    pub fn home_joints(&self) -> &[f64] {
        &self.home.joints
    }

    /// Directions of the legs at home, base frame, of length one; `None` for legs whose points are not both known.
    pub fn home_legs(&self) -> &[Option<Vector3<f64>>] {
        &self.home.legs
    }

    /// Number of joints.
    pub fn joints(&self) -> usize {
        self.mechanism.joints().len()
    }

    /// True if every joint is a length.
    pub fn joints_are_lengths(&self) -> bool {
        self.mechanism.joints().iter().all(|j| j.dimension == Dimension::Length)
    }

    /// True if the parameters hold the points of a body.
    pub fn has_points(&self, body: Body) -> bool {
        self.mechanism.parameters().iter().any(|p| body.coordinate(p.role).is_some())
    }

    /// True if the joints are the coordinates of the pose itself.
    pub fn is_pose_space(&self) -> bool {
        self.mechanism.parameters().iter().all(|p| matches!(p.role, ParameterRole::PoseOffset { .. }))
            && !self.mechanism.parameters().is_empty()
    }
}

/// Unit vectors from the base to the platform along the legs; `None` where a leg has no point on one of them.
pub(crate) fn leg_directions(mechanism: &dyn Mechanism, c: &[f64], pose: &Pose) -> Vec<Option<Vector3<f64>>> {
    let mut directions = vec![None; mechanism.joints().len()];
    let base = Body::Base.points(mechanism, c);
    for (leg, a) in Body::Platform.points(mechanism, c) {
        let Some((_, b)) = base.iter().find(|(l, _)| *l == leg) else { continue };
        if let Some(direction) = directions.get_mut(leg) {
            *direction = (pose.place(&a) - b).try_normalize(0.0);
        }
    }
    directions
}

/// One sample, for effects.
#[derive(Clone, Debug)]
pub struct Site<'a> {
    /// The machine.
    pub context: &'a EffectContext<'a>,
    /// Parameters of the mechanism.
    pub values: &'a [f64],
    /// Commanded joints.
    pub joints: &'a [f64],
    /// Pose of the platform.
    pub pose: &'a Pose,
    /// Operating state.
    pub conditions: &'a Conditions,
    /// Small motion of the platform per unit of each joint (6 × n); by virtual work its transpose carries a wrench
    /// about the platform's origin to the forces of the joints.
    pub joint_motion: &'a Matrix6xX<f64>,
}

impl Site<'_> {
    /// A temperature less its reference; `None` if it was not recorded.
    pub fn temperature(&self, covariate: &str) -> Option<f64> {
        let environment = self.context.environment;
        // Most are recorded under their own name, and this is asked for every leg of every sample.
        let recorded = self.conditions.get(covariate);
        let value = recorded.or_else(|| environment.condition_kinds.value(covariate, self.conditions, self.joints))?;
        Some(environment.difference(covariate, value))
    }

    /// A temperature less its reference, at a place of a scan: as a part has it that follows with the lag of the place.
    /// `None` if it was not recorded, or if a lag has no times; beyond the recorded run a part has followed.
    pub fn temperature_at(&self, covariate: &str, at: &ScanPoint) -> Option<f64> {
        let Some(lag) = at.lag else { return self.temperature(covariate) };
        let environment = self.context.environment;
        let run = self.conditions.run.as_ref()?;
        self.conditions.get(TIME)?;
        if run.row >= run.history.rows() {
            return self.temperature(covariate);
        }
        let value = run.history.followed(run.row, covariate, lag, &environment.condition_kinds)?;
        Some(environment.difference(covariate, value))
    }

    /// Unit vectors along the legs, from base to platform.
    pub fn legs(&self) -> Vec<Option<Vector3<f64>>> {
        leg_directions(self.context.mechanism, self.values, self.pose)
    }
}
