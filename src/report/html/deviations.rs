//! Deviations of the parameters from the file that are those of the machine, and not of the place of tracker and target.

use nalgebra::{DMatrix, DVector};

use super::page::Part;
use crate::identification::{Calibration, Estimate};
use crate::mechanism::{Body, ParameterRole, rigid_directions};
use crate::solve::minimum_norms;
use crate::units::{Dimension, fixed, show_quantity};

/// The parameters in the frame of the mechanism file, then those of the measurement. Where the frames of the data were
/// found, the rigid motions of base and platform that are left are taken out of the points: they are a matter of where
/// frames lie.
pub(super) fn in_the_drawing(c: &Calibration) -> Vec<Estimate> {
    let found = &c.identification;
    let n = found.mechanism_parameters;
    let mut all = found.parameters.clone();
    if !c.registration.applied {
        return all;
    }
    let Some(rigid) = rigid_motions(c, &all[..n]) else { return all };
    let keep = DMatrix::identity(n, n) - &rigid * minimum_norms(&rigid, &DMatrix::identity(n, n));
    let deviation = &keep * DVector::from_iterator(n, all[..n].iter().map(|p| p.value - p.start));
    let covariance = &keep * found.mechanism_covariance() * keep.transpose();
    for (k, p) in all[..n].iter_mut().enumerate() {
        p.value = p.start + deviation[k];
        p.sigma = p.sigma.map(|_| covariance[(k, k)].max(0.0).sqrt());
    }
    all
}

/// Columns of small rigid motions of the points of each body, as the drawing has them.
fn rigid_motions(c: &Calibration, parameters: &[Estimate]) -> Option<DMatrix<f64>> {
    let start: Vec<f64> = parameters.iter().map(|p| p.start).collect();
    let drawn = c.mechanism.with_values(&start, c.mechanism.home()).ok()?;
    let scale = vec![1.0; start.len()];
    let of_body = |body| rigid_directions(drawn.as_ref(), body, &scale);
    Some(DMatrix::from_columns(&[Body::Base, Body::Platform].map(of_body).concat()))
}

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
