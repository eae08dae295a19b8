//! Covariates recorded with the samples, and those that follow from the commands.

use crate::conditions::{Commanded, ConditionTable, Extent, Role, TIME, of_leg};
use crate::diagnosis::answer::unknown::COORDINATES;
use crate::diagnosis::linear::hypotheses::Hypotheses;
use crate::diagnosis::linear::unit_motion::Place;
use crate::measurement::{Dataset, Rows};
use crate::mechanism::{ForwardQuery, Mechanism, characteristic_length};
use crate::pose::{Pose, PoseConvention};

/// A covariate of every sample.
#[derive(Clone, Debug)]
pub(crate) struct Covariate {
    pub(crate) name: String,
    /// The only place that it concerns: what belongs to a leg acts there alone. `None` if it concerns all.
    pub(crate) own: Option<Place>,
    pub(crate) values: Vec<f64>,
    pub(crate) asked: Asked,
}

/// What is looked for in a covariate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Asked {
    /// Degree of the polynomial; 0 for none.
    pub(crate) degree: usize,
    pub(crate) waves: bool,
    pub(crate) jumps: bool,
}

/// Degree of the polynomial in what was recorded, and in a coordinate of the pose.
pub(crate) const DEGREE: usize = 4;
const DEGREE_IN_POSE: usize = 2;

impl Covariate {
    pub(crate) fn range(&self) -> (f64, f64) {
        self.values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)))
    }

    /// Scaled to -1 … 1.
    pub(crate) fn scaled(&self) -> Vec<f64> {
        let (low, high) = self.range();
        self.values.iter().map(|v| 2.0 * (v - low) / (high - low) - 1.0).collect()
    }
}

/// The recorded and derived covariates that change.
pub(crate) fn covariates(data: &Dataset, kinds: &ConditionTable) -> Vec<Covariate> {
    let mut all: Vec<Covariate> = Vec::new();
    let mut add = |name: String, leg: Option<usize>, waves: bool, get: &dyn Fn(usize) -> Option<f64>| {
        let values: Option<Vec<f64>> = (0..data.len()).map(get).collect();
        if let Some(values) = values {
            let asked = Asked { degree: DEGREE, waves, jumps: true };
            let covariate = Covariate { name, own: leg.map(Place::Joint), values, asked };
            let (low, high) = covariate.range();
            if high - low > 1e-9 * low.abs().max(high.abs()) {
                all.push(covariate);
            }
        }
    };
    let Some(first) = (!data.is_empty()).then(|| data.sample(0)) else { return all };
    let names: Vec<&String> = first.conditions.covariates.keys().collect();
    for name in &names {
        let kind = kinds.of(name).filter(|kind| kind.is_recorded());
        let leg = kind.and_then(|_| kinds.leg_of(name));
        let waves = kind.is_some_and(|kind| kind.repeats);
        add((*name).clone(), leg, waves, &|k| data.sample(k).conditions.get(name));
    }
    for kind in kinds.iter().filter(|kind| kind.is_recorded() && kind.extent == Extent::EachLeg) {
        let mean = kind.of_all_legs();
        if !names.contains(&&mean) {
            add(mean, None, false, &|k| data.sample(k).conditions.mean_of_legs(&kind.name));
        }
    }
    if !names.iter().any(|n| *n == TIME) {
        add("row".into(), None, true, &|k| Some(data.sample(k).row.0 as f64));
    }
    for leg in 0..first.joints.len() {
        // The direction of approach is the sign of the travel, whose steps show it.
        for kind in kinds.iter().filter(|kind| searched(kind.role)) {
            let name = of_leg(&kind.name, leg);
            let value = |k: usize| kinds.value(&name, &data.sample(k).conditions, &data.sample(k).joints);
            add(name.clone(), Some(leg), kind.repeats, &value);
        }
    }
    all
}

/// These covariates, and the coordinates of the pose where they are not the joints.
pub(crate) fn with_coordinates(known: &[Covariate], subject: &Hypotheses<'_>) -> Vec<Covariate> {
    let mut all = known.to_vec();
    if !subject.is_pose_space() {
        all.extend(coordinates_of_pose(subject.mechanism, subject.data));
    }
    all
}

/// Where the platform is commanded to be, as covariates of what depends on the pose; none that hardly changes, and none of a
/// mechanism whose joints they are. Of a coordinate alone its instrument may err periodically in it, and by the way that it came.
fn coordinates_of_pose(mechanism: &dyn Mechanism, data: &Dataset) -> Vec<Covariate> {
    let home = mechanism.home();
    let queries: Vec<ForwardQuery<'_>> =
        data.iter().map(|s| ForwardQuery::new(&s.joints, &s.conditions, home)).collect();
    let poses: Result<Vec<Pose>, _> = mechanism.forward_batch(mechanism.values(), &queries).into_iter().collect();
    let Ok(poses) = poses else { return Vec::new() };
    let convention = PoseConvention::default();
    let seen: Vec<[f64; 6]> = poses.iter().map(|pose| convention.coordinates(pose)).collect();
    let sizes = [characteristic_length(mechanism), 1.0];
    let of = |k: usize| {
        let values: Vec<f64> = seen.iter().map(|q| q[k]).collect();
        // The first row came from home, as far as is known.
        let home = convention.coordinates(&home)[k];
        let before = std::iter::once(home).chain(values.iter().copied());
        let travel: Vec<f64> = values.iter().zip(before).map(|(now, before)| now - before).collect();
        let asked = |degree: usize, waves: bool, jumps: bool| Asked { degree, waves, jumps };
        let (name, own) = (COORDINATES[k].to_owned(), Some(Place::Coordinate(k)));
        [
            Covariate {
                name: name.clone(),
                own: None,
                values: values.clone(),
                asked: asked(DEGREE_IN_POSE, false, false),
            },
            Covariate { name: name.clone(), own, values, asked: asked(0, true, false) },
            Covariate { name: format!("travel_{name}"), own, values: travel, asked: asked(0, false, true) },
        ]
    };
    let moves = |k: &usize| {
        let values = || seen.iter().map(|q| q[*k]);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min) > MOVES * sizes[k / 3]
    };
    let read = height_is_along(data, &poses[0]);
    (0..6).filter(|k| !read[*k]).filter(moves).flat_map(of).collect()
}

/// The coordinates along which heights are measured, where nothing else is: a machine that went down until it touched stands
/// there because of its errors, and the commanded coordinate is the reading itself.
fn height_is_along(data: &Dataset, pose: &Pose) -> [bool; 6] {
    if !data.heights_only() {
        return [false; 6];
    }
    let own: Vec<f64> = data.model().nuisance_parameters().iter().map(|_| 0.0).collect();
    let mut rows = Rows::sized(data.rows(0).len(), own.len());
    data.evaluate(0, pose, &own, &mut rows);
    let turns = rows.motion.row(0).columns(0, 3).amax();
    std::array::from_fn(|k| k < 3 && rows.motion[(0, k)].abs() > 0.5 * turns)
}

/// Part of the size of the platform (or of a radian) by which a coordinate must change.
const MOVES: f64 = 1e-6;

fn searched(role: Role) -> bool {
    matches!(role, Role::Commanded(Commanded::Coordinate | Commanded::Travel))
}
