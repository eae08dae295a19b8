//! The object of `settle`, and what `select --for-diagnosis` adds.

use serde_json::{Map, Value, json};

use super::real;
use crate::diagnosis::{Diagnosis, MeasurementPlan, NotFound, NotTestable};
use crate::report::text::CampaignLimits;

/// The object of `settle`.
pub fn settlement(found: &Diagnosis, plans: &[MeasurementPlan]) -> Value {
    let plan = |p: &MeasurementPlan| {
        let pairs: Vec<Value> = p
            .separations
            .iter()
            .map(|s| json!({ "effect": s.effect, "rival": s.rival, "separability": real(s.separability) }))
            .collect();
        let conditions: Vec<Value> = p.samples.iter().map(|s| json!(s.conditions.covariates)).collect();
        let joints: Vec<&Vec<f64>> = p.samples.iter().map(|s| &s.joints).collect();
        json!({
            "what": p.what, "separations": pairs, "weakest": real(p.weakest()), "settles": p.settles(),
            "joints": joints, "conditions": conditions,
        })
    };
    json!({
        "verdict": found.verdict.word(),
        "causes": found.causes.iter().map(|c| c.effect.as_str()).collect::<Vec<_>>(),
        "measurements": plans.iter().map(plan).collect::<Vec<_>>(),
    })
}

/// Limits and what is missing.
pub fn detection_limits(limits: &[NotFound], missing: &[NotTestable]) -> Value {
    let limits: Vec<Value> = limits
        .iter()
        .map(|n| json!({ "effect": n.effect, "parameter": n.parameter, "limit": real(n.limit), "unit": n.dimension.si() }))
        .collect();
    let missing: Vec<Value> = missing.iter().map(|n| json!({ "effect": n.effect, "missing": n.missing })).collect();
    json!({ "detection_limits": limits, "not_testable": missing })
}

/// The keys of a planned campaign.
pub fn campaign_limits(c: &CampaignLimits) -> Map<String, Value> {
    let mut keys = Map::new();
    keys.insert("planned_conditions".into(), json!(c.conditions));
    if let Value::Object(limits) = detection_limits(&c.limits, &c.missing) {
        keys.extend(limits);
    }
    keys
}
