//! Measurements that could be added: other poses, and above all other conditions.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use crate::conditions::{ConditionKind, ConditionTable, Conditions, Extent, Part, Role, TIME, of_leg};
use crate::diagnosis::answer::result::{Cause, Diagnosis};
use crate::diagnosis::question::Question;
use crate::effect::{ActsOn, ScanPoint};
use crate::measurement::{DataRow, Sample};
use crate::mechanism::Mechanism;
use crate::units::three_digits;

/// Samples that a plan adds.
const ADDED: usize = 12;
/// By how much bodies are heated, and single ones among them, K.
const WARM: f64 = 2.0;
const HOT: f64 = 5.0;

/// How much farther from home poses are measured where growth looks like a motion of the frame.
const FAR: [f64; 2] = [4.0, 8.0];

/// What to do in a sentence, and the samples to add.
pub(crate) type Plan = (String, Vec<Sample>);

/// The present data, then plans for what the names and their rivals depend on.
pub(crate) fn scenarios(question: &Question<'_>, mechanism: &dyn Mechanism, found: &Diagnosis) -> Vec<Plan> {
    let further = Further::new(question, mechanism, found);
    let mut all = vec![("nothing more: the present data only".into(), Vec::new()), further.same(), further.wide()];
    all.extend(further.temperatures());
    all.extend(further.conditions());
    all.extend(FAR.into_iter().filter_map(|times| further.far_and_warm(times)));
    all
}

/// What further measurements start from: the run, its poses, and what the names and their rivals depend on.
struct Further<'a> {
    question: &'a Question<'a>,
    mechanism: &'a dyn Mechanism,
    kinds: &'a ConditionTable,
    /// Samples of the run whose poses are measured again.
    chosen: Vec<&'a Sample>,
    /// The conditions at the end of the run.
    last: &'a Conditions,
    /// Covariates that the names and their rivals depend on.
    depends: BTreeSet<String>,
    /// The names and their rivals.
    names: Vec<String>,
    /// The leg that is named.
    leg: usize,
}

impl<'a> Further<'a> {
    fn new(question: &'a Question<'a>, mechanism: &'a dyn Mechanism, found: &Diagnosis) -> Self {
        let data = question.data;
        let n = data.len();
        let of_rivals = |c: &Cause| c.rivals().find_map(|r| r.leg);
        Self {
            question,
            mechanism,
            kinds: &question.environment.condition_kinds,
            chosen: (0..ADDED).map(|k| data.sample(k * (n - 1) / (ADDED - 1))).collect(),
            last: &data.sample(n - 1).conditions,
            depends: depends_on(question, found),
            names: names_of(found),
            leg: found.causes.iter().find_map(|c| c.leg.or_else(|| of_rivals(c))).unwrap_or(0),
        }
    }

    /// True if a name or a rival depends on a kind of condition that acts in such a way.
    fn depends_on_role(&self, fits: impl Fn(Role) -> bool) -> bool {
        self.depends.iter().any(|name| self.kinds.of(name).is_some_and(|kind| fits(kind.role)))
    }

    /// The chosen poses after the run, with its last conditions and one change to each.
    fn plan(&self, change: impl Fn(usize, &mut Conditions)) -> Vec<Sample> {
        let n = self.question.data.len();
        let mut previous = self.question.data.sample(n - 1).joints.clone();
        let make = |(k, s): (usize, &&Sample)| {
            let mut conditions = self.last.clone();
            conditions.previous_joints = Some(std::mem::replace(&mut previous, s.joints.clone()));
            if let Some(run) = &mut conditions.run {
                run.row = n + k;
                run.part = 1.05 + 0.01 * k as f64;
            }
            change(k, &mut conditions);
            Sample { id: None, row: DataRow(n + k), joints: s.joints.clone(), conditions }
        };
        self.chosen.iter().enumerate().map(make).collect()
    }

    fn same(&self) -> Plan {
        let samples = self.plan(|k, c| {
            let time = c.get(TIME);
            c.covariates.clone_from(&self.chosen[k].conditions.covariates);
            c.gravity = self.chosen[k].conditions.gravity;
            if let Some(time) = time {
                c.covariates.insert(TIME.into(), time);
            }
        });
        (format!("{ADDED} more poses under the conditions of the run"), samples)
    }

    fn wide(&self) -> Plan {
        let mut samples = self.plan(|_, _| {});
        for sample in &mut samples {
            if let Some(joints) = self.farther(&sample.joints, 2.0).filter(|j| self.mechanism.within_strokes(j)) {
                sample.joints = joints;
            }
        }
        (format!("{ADDED} poses twice as far from home"), samples)
    }

    /// Poses far from home, each with the temperatures as they are and with each body in turn heated: what grows moves them
    /// otherwise than those near home, and a frame moves all alike.
    fn far_and_warm(&self, times: f64) -> Option<Plan> {
        let follows =
            |name: &str| self.question.catalogue.get(name).is_some_and(|e| e.acts_on() == ActsOn::Measurement);
        let warm = self.depends_on_role(|role| matches!(role, Role::Temperature(_)));
        if !(warm && self.names.iter().any(|name| follows(name))) {
            return None;
        }
        let bodies = self.bodies();
        let states = bodies.len() + 1;
        let far: Vec<Vec<f64>> = self
            .chosen
            .iter()
            .filter_map(|s| self.farther(&s.joints, times))
            .filter(|j| self.mechanism.within_strokes(j))
            .collect();
        if far.len() < self.chosen.len() {
            return None;
        }
        let mut samples = Vec::with_capacity(ADDED * states);
        for state in 0..states {
            let mut part = self.plan(|_, c| {
                if let Some(names) = state.checked_sub(1).map(|body| &bodies[body]) {
                    heat(c, names, HOT);
                }
            });
            for (k, (sample, joints)) in part.iter_mut().zip(&far).enumerate() {
                let row = self.question.data.len() + ADDED * state + k;
                sample.joints.clone_from(joints);
                sample.row = DataRow(row);
                if let Some(run) = &mut sample.conditions.run {
                    run.row = row;
                }
            }
            samples.extend(part);
        }
        let what = "as the temperatures are and with each body in turn (platform, base, all legs, one leg)";
        Some((
            format!("{ADDED} poses {times} times as far from home if they can be reached, {what} heated by {HOT} K"),
            samples,
        ))
    }

    /// The joints of the pose so many times as far from home.
    fn farther(&self, joints: &[f64], times: f64) -> Option<Vec<f64>> {
        let (mechanism, convention, at) = (self.mechanism, &self.question.convention, Conditions::unknown());
        let pose = mechanism.forward(mechanism.values(), joints, &at, &mechanism.home()).ok()?;
        let (q, home) = (convention.coordinates(&pose), convention.coordinates(&mechanism.home()));
        let far: [f64; 6] = std::array::from_fn(|k| home[k] + times * (q[k] - home[k]));
        mechanism.inverse(mechanism.values(), &convention.pose(&far), &at).ok()
    }

    /// The temperatures that are recorded and of which `fits` is true.
    fn recorded(&self, fits: impl Fn(&str, &ConditionKind, Part) -> bool) -> Vec<String> {
        let is_one = |name: &&String| {
            self.kinds.of(name).is_some_and(|kind| match kind.role {
                Role::Temperature(part) => fits(name, kind, part),
                _ => false,
            })
        };
        self.last.covariates.keys().filter(is_one).cloned().collect()
    }

    /// The temperatures of the platform, of the base, of all legs, and of the named leg.
    fn parts(&self) -> [Vec<String>; 4] {
        let body = |wanted: Part| self.recorded(|_, kind, part| part == wanted && kind.extent == Extent::Machine);
        let legs = self.recorded(|_, _, part| part == Part::Leg);
        let own = self.recorded(|name, _, part| part == Part::Leg && self.kinds.leg_of(name) == Some(self.leg));
        [body(Part::Platform), body(Part::Base), legs, own]
    }

    /// Those of them that were recorded.
    fn bodies(&self) -> Vec<Vec<String>> {
        self.parts().into_iter().filter(|names| !names.is_empty()).collect()
    }

    /// Plans that heat and cool.
    fn temperatures(&self) -> Vec<Plan> {
        let all = self.recorded(|_, _, _| true);
        let depends = self.depends_on_role(|role| matches!(role, Role::Temperature(_) | Role::Clock));
        if all.is_empty() || !depends {
            return Vec::new();
        }
        let first = &self.question.data.sample(0).conditions;
        let cooled = self.plan(|_, c| {
            c.covariates.extend(all.iter().filter_map(|name| Some((name.clone(), first.get(name)?))));
        });
        let cooled =
            (format!("{ADDED} poses after the machine has returned to the temperatures of the first row"), cooled);
        let heated = |what: &str, names: &[String], by: f64| {
            let samples = || self.plan(|_, c| heat(c, names, by));
            (!names.is_empty()).then(|| (format!("{ADDED} poses with only {what} heated by {by} K"), samples()))
        };
        let [platform, base, legs, own] = self.parts();
        // One thing after the other settles what no single one does.
        let bodies = self.bodies();
        let in_turn = (bodies.len() > 1).then(|| {
            let samples = self.plan(|k, c| heat(c, &bodies[k % bodies.len()], HOT));
            let what = "each body in turn (platform, base, all legs, one leg)";
            (format!("{ADDED} poses with {what} heated by {HOT} K"), samples)
        });
        let plans = [
            Some(cooled),
            heated("the legs", &legs, WARM),
            heated(&format!("leg {}", self.leg + 1), &own, HOT),
            in_turn,
            heated("the platform", &platform, WARM),
            heated("the base", &base, WARM),
        ];
        plans.into_iter().flatten().collect()
    }

    /// Plans that take other conditions to the ends of their variation, or of what was recorded.
    fn conditions(&self) -> Vec<Plan> {
        let weighs = |role| matches!(role, Role::Direction | Role::Load);
        let gravity = self.depends_on_role(weighs) && self.last.gravity.is_some();
        let mut plans = Vec::new();
        for kind in self.kinds.iter() {
            match kind.role {
                Role::Direction if gravity => plans.extend(self.tipped(kind)),
                Role::Load if gravity => plans.extend(self.in_turn(kind)),
                Role::Reading if self.depends.iter().any(|name| self.kinds.of(name) == Some(kind)) => {
                    plans.extend(self.in_turn(kind));
                }
                _ => {}
            }
        }
        let unlisted = self.depends.iter().filter(|name| self.kinds.of(name).is_none());
        plans.extend(unlisted.filter_map(|name| {
            let ends = self.range(name)?;
            let what = format!("{name} {} and {}", three_digits(ends[0]), three_digits(ends[1]));
            Some(self.to_ends(&what, std::slice::from_ref(name), ends))
        }));
        plans
    }

    /// Gravity at both ends of the angle from which it follows.
    fn tipped(&self, kind: &ConditionKind) -> Option<Plan> {
        let ends = kind.ends()?;
        let samples = self.plan(|k, c| {
            let elevation = ends[k % 2];
            // Gravity stays in the plane in which it was.
            let from = self.chosen[k].conditions.gravity;
            let across = from.map(|g| Vector3::new(g.x, g.y, 0.0)).filter(|g| g.norm() > 1e-6);
            let axis = across.map_or_else(Vector3::x, |g| g.normalize());
            c.gravity = Some(axis * elevation.cos() - Vector3::z() * elevation.sin());
            c.covariates.insert(kind.name.to_string(), elevation);
        });
        Some((format!("{ADDED} poses alternating between {}", between(kind, ends)), samples))
    }

    /// A condition at its ends in turn, and, if there is one for each leg, that of the named leg alone.
    fn in_turn(&self, kind: &ConditionKind) -> Vec<Plan> {
        let recorded = |name: &&String| self.kinds.of(name) == Some(kind);
        let names: Vec<String> = self.last.covariates.keys().filter(recorded).cloned().collect();
        let Some(ends) = kind.ends().or_else(|| self.range(names.first()?)).filter(|_| !names.is_empty()) else {
            return Vec::new();
        };
        let what = between(kind, ends);
        let own = of_leg(&kind.name, self.leg);
        let alone = (kind.extent == Extent::EachLeg && names.len() > 1 && names.contains(&own))
            .then(|| self.to_ends(&format!("{what} at leg {} only", self.leg + 1), &[own], ends));
        std::iter::once(self.to_ends(&what, &names, ends)).chain(alone).collect()
    }

    fn to_ends(&self, what: &str, names: &[String], ends: [f64; 2]) -> Plan {
        let samples = self.plan(|k, c| c.covariates.extend(names.iter().map(|name| (name.clone(), ends[k % 2]))));
        (format!("{ADDED} poses alternating between {what}"), samples)
    }

    /// Smallest and largest value of a covariate in the run; `None` if it was not recorded throughout, or did not change.
    fn range(&self, name: &str) -> Option<[f64; 2]> {
        let values: Option<Vec<f64>> = self.question.data.iter().map(|s| s.conditions.get(name)).collect();
        let values = values?;
        let range = values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(*v), b.max(*v)]);
        (range[0] < range[1]).then_some(range)
    }
}

/// Raises these temperatures.
fn heat(conditions: &mut Conditions, names: &[String], by: f64) {
    for name in names {
        if let Some(t) = conditions.covariates.get_mut(name) {
            *t += by;
        }
    }
}

/// Both ends of a variation, SI, in words: `elevation 20 deg and 90 deg`, `no payload and 100 kg`.
fn between(kind: &ConditionKind, [from, to]: [f64; 2]) -> String {
    match kind.role {
        Role::Load if from == 0.0 => format!("no {} and {}", kind.label, kind.shown(to)),
        _ => format!("{} {} and {}", kind.label, kind.shown(from), kind.shown(to)),
    }
}

/// The names and their rivals.
fn names_of(found: &Diagnosis) -> Vec<String> {
    let rivals = found.causes.iter().flat_map(Cause::rivals).map(|r| r.effect.clone());
    found.causes.iter().map(|c| c.effect.clone()).chain(rivals).collect()
}

/// The covariates that the names and their rivals depend on.
fn depends_on(question: &Question<'_>, found: &Diagnosis) -> BTreeSet<String> {
    let names = found.causes.iter().map(|c| (&c.effect, c.leg, &c.of));
    let rivals = found.causes.iter().flat_map(Cause::rivals).map(|r| (&r.effect, r.leg, &r.of));
    let covariates = |(name, leg, of): (&String, Option<usize>, &Option<String>)| {
        let at = ScanPoint { covariate: of.clone(), ..ScanPoint::leg(leg.unwrap_or(0)) };
        question.catalogue.get(name).map(|effect| effect.covariates(&at)).unwrap_or_default()
    };
    names.chain(rivals).flat_map(covariates).collect()
}
