//! Where base and target stand: the frames of a page.

use super::page::Part;
use crate::identification::{Estimate, Plausibility, plausibility};
use crate::measurement::Frames;
use crate::mechanism::{Mechanism, ParameterRole, characteristic_length};
use crate::pose::{Pose, rotation_vector};
use crate::units::{Dimension, fixed, show_angle, show_length};

/// Frames nearer than this part of the platform's radius, or turned by less than this in rad, are the same.
const NEAR: f64 = 0.05;

/// Where the base of a mechanism and the target stand in the frames of its poses, `drawn` being its drawing: identities if
/// its poses are those of the drawing.
pub fn frames_of(mechanism: &dyn Mechanism, drawn: &dyn Mechanism) -> Frames {
    if let Some((base, target)) = mechanism.mounting() {
        return Frames { base, target };
    }
    let found = plausibility(drawn, mechanism.values());
    let near = NEAR * characteristic_length(mechanism);
    let same = |pose: &Pose| pose.position.norm() < near && rotation_vector(&pose.rotation).norm() < NEAR;
    if same(&found.base) && same(&found.target) {
        return Frames::default();
    }
    Frames { base: found.base, target: found.target }
}

/// Distances and turns in a sentence, as the text output states them.
pub(super) fn sentence(found: &Plausibility) -> String {
    let turn = |pose: &Pose| show_angle(rotation_vector(&pose.rotation).norm());
    format!(
        "The base stands {} from the origin of the tracker's frame and is turned by {} in it; the target sits {} from the \
         origin of the platform, turned by {}.",
        show_length(found.base.position.norm()),
        turn(&found.base),
        show_length(found.target.position.norm()),
        turn(&found.target)
    )
}

/// The rigid motions as a table.
pub(super) fn motions(found: &Plausibility) -> Part {
    let row = |name: &str, pose: &Pose| {
        let q = pose.coordinates();
        let mm = (0..3).map(|k| fixed(1e3 * q[k], 3));
        let degrees = (3..6).map(|k| fixed(q[k].to_degrees(), 5));
        let mut row = vec![name.to_owned()];
        row.extend(mm.chain(degrees));
        row.push(show_length(pose.position.norm()));
        row.push(show_angle(rotation_vector(&pose.rotation).norm()));
        row
    };
    let rows = vec![row("base in the tracker's frame", &found.base), row("target on the platform", &found.target)];
    Part::Table(
        vec!["rigid motion", "x (mm)", "y (mm)", "z (mm)", "rx (deg)", "ry (deg)", "rz (deg)", "distance", "rotation"],
        rows,
    )
}

/// The offsets of the joints as a table, if there are any; `sigma` has their uncertainties.
pub(super) fn offsets(mechanism: &dyn Mechanism, found: &Plausibility, estimates: &[Estimate]) -> Option<Part> {
    let shown = |v: f64, dimension: Dimension| {
        let (unit, per_si) = dimension.in_tables();
        format!("{} {unit}", fixed(per_si * v, if dimension == Dimension::Length { 4 } else { 5 }))
    };
    let of_joints = mechanism.parameters().iter().filter_map(|spec| match spec.role {
        ParameterRole::JointOffset { leg } => Some((leg, spec)),
        _ => None,
    });
    let row = |((leg, spec), offset): ((usize, &crate::mechanism::ParameterSpec), &f64)| {
        let sigma = estimates.iter().find(|e| e.spec.name == spec.name).and_then(|e| e.sigma);
        let mut row = vec![format!("leg {}", leg + 1), shown(*offset, spec.dimension)];
        row.extend((!estimates.is_empty()).then(|| sigma.map_or_else(|| "?".into(), |s| shown(s, spec.dimension))));
        row
    };
    let rows: Vec<Vec<String>> = of_joints.zip(&found.leg_offsets).map(row).collect();
    let mut header = vec!["offset of a leg", "true minus commanded, against the file"];
    if !estimates.is_empty() {
        header.push("σ");
    }
    (!rows.is_empty()).then_some(Part::Table(header, rows))
}
