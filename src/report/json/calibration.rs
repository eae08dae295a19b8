//! The object of `calibrate`.

use serde_json::{Value, json};

use super::{errors, motion, predicted, real, rows};
use crate::identification::{Calibration, Deviation, Estimate, GROUPS};
use crate::mechanism::ParameterRole;
use crate::report::in_the_drawing::in_the_drawing;
use crate::units::Dimension;

/// Pairs of correlated parameters that are listed.
const CORRELATIONS: usize = 10;

/// A parameter, and the same in the frames of the drawing, whose deviation is the one that the text shows.
fn estimate((p, drawn): (&Estimate, &Estimate)) -> Value {
    json!({
        "name": p.spec.name,
        "nominal": real(p.spec.nominal),
        "value": real(p.value),
        "deviation": real(drawn.value - drawn.start),
        "sigma": p.sigma.map(real),
        "unit": p.spec.dimension.si(),
    })
}

/// False for the offset of a joint that is not a length.
fn length_offset(p: &Estimate) -> bool {
    !matches!(p.spec.role, ParameterRole::JointOffset { .. }) || p.spec.dimension == Dimension::Length
}

/// Measured minus predicted for each quantity of a complete reading; `null` where it was not measured. A pose has six.
fn residual_row(deviation: &Deviation) -> Vec<Value> {
    let value = |row: &Option<usize>| row.map_or(Value::Null, |k| real(deviation.readings[k].1));
    deviation.row_of_each.iter().map(value).collect()
}

/// The object of `calibrate`; `residuals` are the deviations of the samples from the calibrated mechanism.
pub fn calibration(c: &Calibration, residuals: &[Deviation]) -> Value {
    let found = &c.identification;
    let n = found.mechanism_parameters;
    let drawn = in_the_drawing(c);
    let history: Vec<Value> = found
        .history
        .iter()
        .map(|h| json!({ "cost": real(h.cost), "step": real(h.step), "damping": real(h.damping) }))
        .collect();
    let pairs = found.strongest_correlations(CORRELATIONS);
    let pair = |(a, b, r): &(&str, &str, f64)| json!({ "first": a, "second": b, "correlation": r });
    let correlations: Vec<Value> = pairs.iter().map(pair).collect();
    json!({
        "identifier": c.identifier,
        "converged": c.converged,
        "convergence": if c.converged { json!(found.convergence.text()) } else { Value::Null },
        "iterations": found.history.len(),
        "history": history,
        "samples": found.poses.len(),
        "parameters": c.parameters.iter().zip(&drawn).take(n).map(estimate).collect::<Vec<_>>(),
        "measurement_parameters": c.parameters.iter().zip(&drawn).skip(n).map(estimate).collect::<Vec<_>>(),
        "correlations": correlations,
        "rms_before": (c.not_reached == 0).then(|| errors(&c.before)),
        "rows_not_reached": c.not_reached,
        "rms_after": errors(&c.after),
        "held_out": c.held_out.as_ref().map(|h| errors(&h.rms)),
        "held_out_p": c.held_out.as_ref().and_then(|h| h.p_value).map(real),
        "held_out_rows": c.held_out.as_ref().map(|h| h.samples),
        "predicted": c.predicted.as_ref().map(predicted),
        "trusted_to": c.predicted.as_ref().filter(|_| c.verdict.trusted).map(|p| json!({
            "position_m": real(p.position_rms), "rotation_rad": real(p.rotation_rms),
        })),
        "misfit": {
            "chi_square": real(found.misfit.chi_square),
            "degrees_of_freedom": found.misfit.degrees_of_freedom,
            "p": found.misfit.p_value().map(real),
        },
        "predicted_of_drawing": c.of_drawing.as_ref().map(predicted),
        "misfit_with_prior": c.drawing.as_ref().map(|d| json!({
            "chi_square": real(d.with_prior.chi_square),
            "degrees_of_freedom": d.with_prior.degrees_of_freedom,
            "p": d.with_prior.p_value().map(real),
        })),
        "tolerance_factors": GROUPS.iter().zip(c.tolerance_factors).map(|(group, f)| (group.to_string(), real(f))).collect::<serde_json::Map<_, _>>(),
        "prior": found.prior,
        "noise_scale": real(found.noise_scale),
        "chi_square": real(found.misfit.chi_square),
        "degrees_of_freedom": found.misfit.degrees_of_freedom,
        "p_value": found.misfit.p_value().map(real),
        "frames": {
            "registered": c.registration.applied,
            "base": motion(&c.plausibility.base),
            "target": motion(&c.plausibility.target),
            "leg_offsets_m": c.parameters[..n].iter().all(length_offset).then_some(&c.plausibility.leg_offsets),
            "joint_offsets": c.plausibility.leg_offsets,
        },
        "weak_directions": c.weak.iter().map(|w| json!({ "sigma": real(w.sigma), "text": w.text })).collect::<Vec<_>>(),
        "implausible": c.plausibility.implausible.iter().map(|p| json!({
            "name": p.name, "deviation": real(p.deviation), "tolerance": real(p.tolerance), "unit": p.dimension.si(),
        })).collect::<Vec<_>>(),
        "outlier_rows": rows(&found.outliers),
        "residuals": residuals.iter().map(residual_row).collect::<Vec<_>>(),
        "trusted": c.verdict.trusted,
        "reasons": c.verdict.reasons,
        "warnings": c.verdict.warnings,
    })
}
