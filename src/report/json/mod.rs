//! One JSON object for each command. Numbers are SI; what is not known is `null`.

mod calibration;
mod diagnosis;
mod settlement;

pub use calibration::calibration;
pub use diagnosis::diagnosis;
pub use settlement::{campaign_limits, detection_limits, settlement};

use nalgebra::Vector3;
use serde_json::{Value, json};

use crate::identification::{ErrorSummary, ModelErrors};
use crate::measurement::DataRow;
use crate::observability::PredictedError;
use crate::pose::Pose;
use crate::report::text::{Inspection, Selection};
use crate::selection::ChosenSet;

/// A number, or `null` if it is not finite.
fn real(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { Value::Null }
}

/// `{position_m, rotation_rad}`.
pub fn errors(e: &ErrorSummary) -> Value {
    json!({ "position_m": e.position.map(real), "rotation_rad": e.rotation.map(real) })
}

/// Numbers of data rows.
fn rows(rows: &[DataRow]) -> Vec<usize> {
    rows.iter().map(|row| row.0).collect()
}

fn motion(pose: &Pose) -> Value {
    let q = pose.coordinates();
    json!({ "position_m": &q[..3], "rotation_rad": &q[3..] })
}

fn predicted(p: &PredictedError) -> Value {
    json!({
        "poses": p.poses,
        "rms": { "position_m": p.position_rms, "rotation_rad": p.rotation_rms },
        "max": { "position_m": p.position_max, "rotation_rad": p.rotation_max },
    })
}

/// The object of `evaluate`.
pub fn evaluation(e: &ModelErrors) -> Value {
    let row = |s: &crate::identification::SampleError| json!({ "row": s.row.0, "position_m": s.position.map(real), "rotation_rad": s.rotation.map(real) });
    json!({
        "rows": e.samples.len(),
        "rms": errors(&e.rms()),
        "mean": errors(&e.mean()),
        "max": errors(&e.max()),
        "errors": e.samples.iter().map(row).collect::<Vec<_>>(),
    })
}

/// The object of `inspect`.
pub fn inspection(i: &Inspection<'_>) -> Value {
    let point = |points: &[(usize, Vector3<f64>)], k: usize| {
        points.iter().find(|(leg, _)| *leg == k).map(|(_, p)| json!([p.x, p.y, p.z]))
    };
    let leg = |k: usize| json!({ "platform": point(&i.platform, k), "base": point(&i.base, k), "length": i.lengths.get(k).copied().map(real) });
    let survey = i.survey.as_ref().map(|s| {
        json!({
            "poses": s.poses, "outside_stroke": s.outside_stroke, "unreachable": s.unreachable,
            "joint_range": s.joint_range, "worst_condition": real(s.worst_condition),
        })
    });
    let outlook = i.preview.as_ref().map(|p| {
        let covariance = &p.forecast.covariance;
        let sigma: Vec<f64> = p.scale.iter().enumerate().map(|(k, s)| s * covariance[(k, k)].sqrt()).collect();
        json!({
            "poses": p.poses.len(), "prior": p.forecast.prior, "sigma": sigma,
            "predicted": predicted(&p.forecast.error), "efficiency": p.efficiency,
        })
    });
    json!({
        "name": i.mechanism.name(),
        "parameters": i.mechanism.parameters().len(),
        "legs": (0..i.legs()).map(leg).collect::<Vec<_>>(),
        "home": i.convention.coordinates(&i.mechanism.home()),
        "joints": i.mechanism.joints().iter().map(|j| j.name.clone()).collect::<Vec<_>>(),
        "joint_units": i.mechanism.joints().iter().map(|j| j.dimension.si()).collect::<Vec<_>>(),
        "home_joints": i.home_joints,
        "strokes": i.mechanism.joints().iter().map(|j| j.stroke).collect::<Vec<_>>(),
        "radius": real(i.radius),
        "condition": real(i.home_condition),
        "workspace": survey,
        "prospect": outlook,
        "weak_directions": i.weak.iter().map(|w| json!({ "sigma": real(w.sigma), "text": w.text })).collect::<Vec<_>>(),
        "warnings": i.warnings,
    })
}

/// The object of `select`; the chosen poses (coordinates, m and rad) and their joints are in the order of the list.
pub fn selection(s: &Selection<'_>, poses: &[[f64; 6]], joints: &[&[f64]], seconds: f64) -> Value {
    let r = s.report;
    let row = |r: &ChosenSet| {
        json!({
            "n": r.poses.len(), "value": real(r.value), "bound": r.bound.map(real), "efficiency": r.efficiency.map(real),
            "predicted": r.forecast.as_ref().map(|f| predicted(&f.error)),
        })
    };
    // Value after each iteration; a selector without iterations has the value of its only set.
    let trace = r.trace.get(usize::from(r.iterations > 0)..).unwrap_or(&[]);
    let mut object = json!({
        "index": r.index,
        "scaling": s.scaling.name(),
        "value": real(r.value),
        "bound": r.bound.map(real),
        "efficiency": r.efficiency.map(real),
        "selector": s.selector,
        "iterations": r.iterations,
        "trace": trace.iter().map(|v| real(*v)).collect::<Vec<_>>(),
        "poses": poses,
        "joints": joints,
        "given": s.given,
        "candidates": r.candidates,
        "invisible_directions": r.invisible,
        "predicted": r.forecast.as_ref().map(|f| predicted(&f.error)),
        "prior": r.forecast.as_ref().map(|f| f.prior),
        "table": s.table.iter().map(row).collect::<Vec<_>>(),
        "seconds": seconds,
    });
    if let (Some(limits), Some(object)) = (s.limits, object.as_object_mut()) {
        object.extend(campaign_limits(limits));
    }
    object
}
