//! Tables of the parameters and their deviations.

use super::page::Part;
use crate::identification::Estimate;
use crate::mechanism::ParameterRole;
use crate::units::{Dimension, fixed, show_quantity};

/// Deviations that are no convention: not the offsets of joints, which the frames are listed with.
pub(super) fn judged(parameters: &[Estimate]) -> Vec<Estimate> {
    let offset = |p: &&Estimate| matches!(p.spec.role, ParameterRole::JointOffset { .. });
    parameters.iter().filter(|p| !offset(p)).cloned().collect()
}

/// Drawing, identified value, deviation and uncertainty of each parameter.
pub(super) fn table(parameters: &[Estimate]) -> Part {
    let row = |p: &Estimate| {
        let name = p.spec.name.clone();
        let deviation = p.value - p.start;
        let decimals = match p.spec.dimension {
            Dimension::Length => 4,
            Dimension::Angle => 5,
            dimension => {
                let shown = |v: f64| show_quantity(v, dimension);
                let sigma = p.sigma.map_or_else(|| "?".into(), shown);
                return vec![name, shown(p.start), shown(p.value), shown(deviation), sigma, String::new()];
            }
        };
        let (unit, per_si) = p.spec.dimension.in_tables();
        let shown = |v: f64| fixed(per_si * v, decimals);
        let plus = if deviation > 0.0 { "+" } else { "" };
        let sigma = p.sigma.map_or_else(|| "?".into(), shown);
        vec![name, shown(p.start), shown(p.value), format!("{plus}{}", shown(deviation)), sigma, unit.to_owned()]
    };
    let header = vec!["parameter", "drawing", "identified", "deviation", "σ", "unit"];
    Part::table("All parameters", header, parameters.iter().map(row).collect())
}
