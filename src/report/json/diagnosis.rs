//! The object of `diagnose`.

use serde_json::{Value, json};

use super::{errors, motion, real, rows};
use crate::diagnosis::{COORDINATES, Cause, Diagnosis, Rival, Unknown};
use crate::effect::ActsOn;
use crate::pose::Pose;

/// The object of `diagnose`.
pub fn diagnosis(d: &Diagnosis) -> Value {
    let g = &d.gain;
    let limits = d.not_found.iter().map(
        |n| json!({ "effect": n.effect, "limit": real(n.limit), "unit": n.dimension.si(), "parameter": n.parameter }),
    );
    let not_testable: Vec<Value> =
        d.not_testable.iter().map(|n| json!({ "effect": n.effect, "missing": n.missing })).collect();
    let frames = (d.frames.base != Pose::identity() || d.frames.target != Pose::identity())
        .then(|| json!({ "base": motion(&d.frames.base), "target": motion(&d.frames.target) }));
    json!({
        "verdict": d.verdict.word(),
        "undecided": d.undecided,
        "causes": d.causes.iter().map(cause).collect::<Vec<_>>(),
        "unknown": d.unknown.as_ref().map(|u| unknown(d, u)),
        "misread": d.misread.as_ref().map(|m| json!({
            "reading": m.reading, "detail": m.detail, "factor": real(m.factor), "tied_with": m.tied_with,
            "tied": !m.alternatives.is_empty(), "rows_failing": m.rows_failing,
            "alternatives": m.alternatives.iter().map(|a| json!({ "reading": a.reading, "detail": a.detail }))
                .collect::<Vec<_>>(),
        })),
        "outlier_rows": rows(&d.outlier_rows),
        "noise_varies": d.noise_varies.as_ref().map(|n| json!({
            "covariate": n.covariate, "ratio": real(n.ratio), "p_value": real(n.p_value),
        })),
        "row_correlation": d.correlation.map(real),
        "gain": {
            "position_before_m": g.position_before.map(real),
            "position_after_m": g.position_after.map(real),
            "rotation_before_rad": g.rotation_before.map(real),
            "rotation_after_rad": g.rotation_after.map(real),
            "blocked_position_before_m": g.blocked_position_before.map(real),
            "blocked_position_after_m": g.blocked_position_after.map(real),
            "blocked_rotation_before_rad": g.blocked_rotation_before.map(real),
            "blocked_rotation_after_rad": g.blocked_rotation_after.map(real),
            "noise_floor_position_m": g.noise_floor_position.map(real),
            "noise_floor_rotation_rad": g.noise_floor_rotation.map(real),
        },
        "residual_before": errors(&d.before),
        "residual_after": errors(&d.after),
        "noise_scale": real(d.noise_scale),
        "samples": d.samples,
        "not_found": limits.collect::<Vec<_>>(),
        "not_testable": not_testable,
        "frames": frames,
        "warnings": d.warnings,
    })
}

fn cause(c: &Cause) -> Value {
    let mut parameters: Vec<Value> = c
        .parameters
        .iter()
        .map(
            |p| json!({ "name": p.name, "value": real(p.value), "sigma": p.sigma.map(real), "unit": p.dimension.si() }),
        )
        .collect();
    if let Some(row) = c.row {
        parameters.push(json!({ "name": "row", "value": row, "sigma": null, "unit": "1" }));
    }
    let tied: Vec<&str> = c.rivals().map(|r| r.effect.as_str()).collect();
    let rivals: Vec<Value> = c
        .tied_with
        .iter()
        .map(|r| {
            let part = |r: &Rival| {
                json!({ "effect": r.effect, "leg": r.leg.map(|leg| leg + 1), "of": r.of, "lag_s": r.lag.map(real) })
            };
            let mut rival = part(r);
            rival["together_with"] = r.together_with.as_deref().map_or(Value::Null, part);
            rival["behind"] = real(r.log_bayes_factor);
            rival["separability"] = real(r.separability);
            rival
        })
        .collect();
    json!({
        "effect": c.effect,
        "cause": c.cause,
        "remedy": c.remedy,
        "acts_on": if c.acts_on == ActsOn::Mechanism { "mechanism" } else { "measurement" },
        "leg": c.leg.map(|leg| leg + 1),
        "of": c.of,
        "lag_s": c.lag.map(real),
        "parameters": parameters,
        "p_value": real(c.p_value),
        "evidence": real(c.evidence),
        "tied_with": tied,
        "rivals": rivals,
        "not_excluded": c.not_excluded,
        "size_over_limit": real(c.size_over_limit),
        "tentative": c.tentative,
        "plausible": c.plausible,
    })
}

fn unknown(d: &Diagnosis, u: &Unknown) -> Value {
    let kind = u.covariate.as_ref().and_then(|name| d.environment.condition_kinds.of(name));
    let in_table = |v: f64| kind.map_or(v, |kind| kind.unit().from_si(v));
    json!({
        "kind": u.kind(),
        "covariate": u.covariate,
        "leg": u.leg.map(|leg| leg + 1),
        "coordinate": u.coordinate.map(|k| COORDINATES[k]),
        "size": u.size.map(real),
        "unit": u.dimension.si(),
        "place": u.from.map(|at| real(in_table(at))),
        "curve": u.course.iter().map(|[at, value]| json!([real(in_table(*at)), real(*value)])).collect::<Vec<_>>(),
        "test": u.test.word(),
        "p_value": real(u.p_value),
        "period": u.period.map(real),
        "runner_up": u.runner_up,
        "withdrawn": u.withdrawn,
    })
}
