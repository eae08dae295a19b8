//! Measurements that could be added: other poses, and above all other conditions.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use crate::conditions::Conditions;
use crate::diagnosis::answer::result::Diagnosis;
use crate::diagnosis::question::Question;
use crate::effect::{ScanPoint, effect};
use crate::measurement::{DataRow, Sample};
use crate::mechanism::Mechanism;

/// Samples that a plan adds.
const ADDED: usize = 12;

/// The present data, then plans for what the names and their rivals depend on.
pub(crate) fn scenarios(
    question: &Question<'_>,
    mechanism: &dyn Mechanism,
    found: &Diagnosis,
) -> Vec<(String, Vec<Sample>)> {
    let data = question.data;
    let n = data.len();
    let chosen: Vec<&Sample> = (0..ADDED).map(|k| data.sample(k * (n - 1) / (ADDED - 1))).collect();
    let last = &data.sample(n - 1).conditions;
    let first = &data.sample(0).conditions;
    let depends = depends_on(found);
    let leg = found.causes.iter().find_map(|c| c.leg.or_else(|| c.tied_with.iter().find_map(|r| r.leg))).unwrap_or(0);
    let temperatures: Vec<String> = last.covariates.keys().filter(|k| k.starts_with("temp_")).cloned().collect();
    let legs: Vec<&String> = temperatures.iter().filter(|t| t.starts_with("temp_leg")).collect();
    // After the run, with its last conditions, one more change each.
    let plan = |change: &dyn Fn(usize, &mut Conditions)| -> Vec<Sample> {
        let mut previous = data.sample(n - 1).joints.clone();
        let make = |(k, s): (usize, &&Sample)| {
            let mut conditions = last.clone();
            conditions.previous_joints = Some(std::mem::replace(&mut previous, s.joints.clone()));
            if let Some(run) = &mut conditions.run {
                run.row = n + k;
                run.part = 1.05 + 0.01 * k as f64;
            }
            change(k, &mut conditions);
            Sample { id: None, row: DataRow(n + k), joints: s.joints.clone(), conditions }
        };
        chosen.iter().enumerate().map(make).collect()
    };
    let mut all: Vec<(String, Vec<Sample>)> = vec![("nothing more: the present data only only".into(), Vec::new())];
    let same = plan(&|k, c| {
        let time = c.get("time");
        c.covariates.clone_from(&chosen[k].conditions.covariates);
        c.gravity = chosen[k].conditions.gravity;
        if let Some(time) = time {
            c.covariates.insert("time".into(), time);
        }
    });
    all.push((format!("{ADDED} more poses under the conditions of the run"), same));
    let mut wide = plan(&|_, _| {});
    for sample in &mut wide {
        let at = Conditions::unknown();
        let pose = mechanism.forward(mechanism.values(), &sample.joints, &at, &mechanism.home());
        let twice = pose.ok().and_then(|pose| {
            let (q, home) =
                (question.convention.coordinates(&pose), question.convention.coordinates(&mechanism.home()));
            let far: [f64; 6] = std::array::from_fn(|k| 2.0 * q[k] - home[k]);
            mechanism.inverse(mechanism.values(), &question.convention.pose(&far), &at).ok()
        });
        if let Some(joints) = twice.filter(|joints| mechanism.within_strokes(joints)) {
            sample.joints = joints;
        }
    }
    all.push((format!("{ADDED} poses twice as far from home"), wide));
    if !temperatures.is_empty() && (depends.contains("temperature") || depends.contains("time")) {
        let cooled = plan(&|_, c| {
            for name in &temperatures {
                if let Some(t) = first.get(name) {
                    c.covariates.insert(name.clone(), t);
                }
            }
        });
        all.push((
            format!(
                "{ADDED} poses after the machine has returned to the temperatures of the first \
                           row"
            ),
            cooled,
        ));
        let recorded = |name: &str| temperatures.iter().find(|t| *t == name).map(|t| vec![t]);
        let heated = |names: &[&String], by: f64| plan(&|_, c| heat(c, names, by));
        if !legs.is_empty() {
            all.push((format!("{ADDED} poses with only the legs heated by 2 K"), heated(&legs, 2.0)));
        }
        let own = format!("temp_leg{}", leg + 1);
        if let Some(names) = recorded(&own) {
            all.push((format!("{ADDED} poses with only leg {} heated by 5 K", leg + 1), heated(&names, 5.0)));
        }
        // One thing after the other settles what no single one does.
        let all_legs = (!legs.is_empty()).then(|| legs.clone());
        let bodies: Vec<Vec<&String>> = [recorded("temp_platform"), recorded("temp_base"), all_legs, recorded(&own)]
            .into_iter()
            .flatten()
            .collect();
        if bodies.len() > 1 {
            let in_turn = plan(&|k, c| heat(c, &bodies[k % bodies.len()], 5.0));
            let what = "poses with each body in turn (platform, base, all legs, one leg) heated by 5 K";
            all.push((format!("{ADDED} {what}"), in_turn));
        }
        for (name, part) in [("temp_platform", "platform"), ("temp_base", "base")] {
            if let Some(names) = recorded(name) {
                all.push((format!("{ADDED} poses with only the {part} heated by 2 K"), heated(&names, 2.0)));
            }
        }
    }
    if depends.contains("gravity") && last.gravity.is_some() {
        let tipped = plan(&|k, c| {
            let from = &chosen[k].conditions;
            let degrees = if k % 2 == 0 { 20.0_f64 } else { 90.0 };
            let elevation = degrees.to_radians();
            // Gravity stays in the plane in which it was.
            let across = from.gravity.map(|g| Vector3::new(g.x, g.y, 0.0)).filter(|g| g.norm() > 1e-6);
            let axis = across.map_or_else(Vector3::x, |g| g.normalize());
            c.gravity = Some(axis * elevation.cos() - Vector3::z() * elevation.sin());
            c.covariates.insert("elevation".into(), elevation);
        });
        all.push((format!("{ADDED} poses alternating between elevation 20 deg and 90 deg"), tipped));
        if last.get("payload").is_some() {
            let loaded = plan(&|k, c| {
                c.covariates.insert("payload".into(), if k % 2 == 0 { 0.0 } else { 100.0 });
            });
            all.push((format!("{ADDED} poses alternating between no payload and 100 kg"), loaded));
        }
    }
    all
}

/// Raises these temperatures.
fn heat(conditions: &mut Conditions, names: &[&String], by: f64) {
    for name in names {
        if let Some(t) = conditions.covariates.get_mut(*name) {
            *t += by;
        }
    }
}

/// Kinds of conditions that the names and their rivals depend on.
fn depends_on(found: &Diagnosis) -> BTreeSet<&'static str> {
    let names = found
        .causes
        .iter()
        .flat_map(|c| c.tied_with.iter().map(|r| r.effect.as_str()).chain(std::iter::once(c.effect.as_str())));
    let mut kinds = BTreeSet::new();
    for name in names {
        let Some(effect) = effect(name) else { continue };
        for covariate in effect.covariates(&ScanPoint::leg(0)) {
            kinds.insert(match covariate.as_str() {
                c if c.starts_with("temp_") => "temperature",
                "elevation" | "payload" => "gravity",
                "time" => "time",
                _ => "other",
            });
        }
    }
    kinds
}
