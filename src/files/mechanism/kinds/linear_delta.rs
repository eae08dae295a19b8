//! `type = "linear-delta"`: six rods on three carriages.

use super::closure_kind::{self, Drawing, PARTS};
use super::file_kind::FileKind;
use super::row::each;
use crate::files::error::FileError;
use crate::files::mechanism::document::MechanismDocument;
use crate::mechanism::closure::ClosureMechanism;
use crate::mechanism::kinds::{LinearDelta, Rod};
use crate::mechanism::{ParameterRole, ParameterSpec};
use crate::units::Dimension;

/// Six rods on three carriages, each on a rail.
pub(super) const KIND: FileKind = FileKind {
    name: "linear-delta",
    label: "six rods on three carriages, each on a rail",
    needed: &["length", "carriage", "rail"],
    optional: &["stroke"],
    parts: PARTS,
    points_move: false,
    example: Some(include_str!("../examples/linear-delta.toml")),
    read: |source, warned| closure_kind::read::<LinearDelta>(&KIND, draw, source, warned),
    write: |mechanism, target, document| closure_kind::write::<LinearDelta>(mechanism, target, document, put),
};

fn draw(drawing: &Drawing<'_>) -> Result<ClosureMechanism<LinearDelta>, FileError> {
    let Drawing { r, legs, home, tolerances, .. } = *drawing;
    let rods = each(r, legs, |at, l| {
        let carriage = l.carriage.unwrap_or(0);
        if !(1..=3).contains(&carriage) {
            return Err(r.value(at.place("carriage"), format!("{carriage} is not 1, 2 or 3")));
        }
        Ok(Rod {
            platform: at.point("platform", &l.platform)?,
            base: at.point("base", &l.base)?,
            length: at.positive("length", l.length)?,
            carriage: carriage - 1,
            rail: at.direction("rail", l.rail)?,
            stroke: at.stroke(l.stroke, Dimension::Length)?,
        })
    })?;
    LinearDelta::new(drawing.name, &rods, home, tolerances).map_err(|cause| r.geometry(cause))
}

fn put(document: &mut MechanismDocument, spec: &ParameterSpec, v: f64) {
    let Some(leg) = spec.role.leg().and_then(|leg| document.legs.get_mut(leg)) else { return };
    if let ParameterRole::LegDimension { .. } = spec.role {
        leg.length = Some(v);
    }
}
