//! What the user should know of a calibration as a whole.

use crate::identification::calibration::Calibration;
use crate::identification::judgement::held_out::Holdout;
use crate::identification::judgement::plausibility::Implausible;
use crate::measurement::{Dataset, RowKind};
use crate::units::show_angle;

/// Adds what the whole calibration says.
pub(crate) fn with_warnings(mut result: Calibration, data: &Dataset, holdout: &Holdout) -> Calibration {
    let warnings = &mut result.verdict.warnings;
    if result.held_out.is_none() && !matches!(holdout, Holdout::None) {
        warnings.push("errors on held-out rows are not available: without them, the remaining rows do not determine the parameters".into());
    }
    if result.not_reached > 0 {
        warnings.push(format!(
            "the mechanism as it is given does not reach {} of the {} data rows, so that there is no error before the \
             calibration",
            result.not_reached,
            data.len()
        ));
    }
    let implausible = &result.plausibility.implausible;
    let in_tolerances = |p: &Implausible| p.deviation.abs() / p.tolerance;
    if let Some(worst) = implausible.iter().max_by(|a, b| in_tolerances(a).total_cmp(&in_tolerances(b))) {
        let (unit, per_si) = worst.dimension.in_tables();
        warnings.push(format!(
            "{} of the parameters deviate by more than 4 tolerances, most of all {} ({:+.3} {unit}); \
             a small residual with such values means that they absorb another cause",
            implausible.len(),
            worst.name,
            per_si * worst.deviation
        ));
    }
    if !data.noise.known && result.identification.misfit.degrees_of_freedom > 0 {
        let scale = result.identification.noise_scale;
        let [mut positions, mut angles] = [false; 2];
        for kind in (0..data.len()).flat_map(|k| data.rows(k)) {
            positions |= kind == RowKind::Position;
            angles |= kind == RowKind::Rotation;
        }
        let of = [
            positions.then(|| format!("{:.3} um per position coordinate", 1e6 * scale * data.noise.position)),
            angles.then(|| format!("{} per angle", show_angle(scale * data.noise.rotation))),
        ];
        let of: Vec<String> = of.into_iter().flatten().collect();
        warnings.push(format!("no noise is stated; it was estimated from the residuals as {}", of.join(" and ")));
    }
    result
}
