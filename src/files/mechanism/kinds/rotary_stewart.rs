//! `type = "rotary-stewart"`: six cranks that turn, with rods to the platform.

use super::closure_kind::{self, Drawing, PARTS, stem};
use super::file_kind::FileKind;
use super::row::{Row, each};
use crate::files::error::FileError;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::sections::LegEntry;
use crate::mechanism::closure::ClosureMechanism;
use crate::mechanism::kinds::{CrankLeg, RodsOnCranks, RotaryStewart};
use crate::mechanism::{ParameterRole, ParameterSpec};
use crate::units::Dimension;

/// Six rods on cranks that turn.
pub(super) const KIND: FileKind = FileKind {
    name: "rotary-stewart",
    label: "six rods on cranks that turn",
    needed: &["length", "crank", "axis", "zero"],
    optional: &["angle_offset", "stroke"],
    parts: PARTS,
    points_move: false,
    example: Some(include_str!("../examples/rotary-stewart.toml")),
    read: |source, warned| closure_kind::read::<RodsOnCranks>(&KIND, draw, source, warned),
    write: |mechanism, target, document| closure_kind::write::<RodsOnCranks>(mechanism, target, document, put),
};

fn draw(drawing: &Drawing<'_>) -> Result<ClosureMechanism<RodsOnCranks>, FileError> {
    let Drawing { r, legs, home, tolerances, .. } = *drawing;
    let legs = each(r, legs, cranked)?;
    RotaryStewart::new(drawing.name, &legs, home, tolerances).map_err(|cause| r.geometry(cause))
}

/// A rod and the crank that moves it.
pub(super) fn cranked(at: &Row<'_>, l: &LegEntry) -> Result<CrankLeg, FileError> {
    Ok(CrankLeg {
        platform: at.point("platform", &l.platform)?,
        base: at.point("base", &l.base)?,
        rod: at.positive("length", l.length)?,
        crank: at.positive("crank", l.crank)?,
        axis: at.direction("axis", l.axis)?,
        zero: at.direction("zero", l.zero)?,
        offset: at.r.units.angle.to_si(at.finite("angle_offset", l.angle_offset)?),
        stroke: at.stroke(l.stroke, Dimension::Angle)?,
    })
}

fn put(document: &mut MechanismDocument, spec: &ParameterSpec, v: f64) {
    let Some(leg) = spec.role.leg().and_then(|leg| document.legs.get_mut(leg)) else { return };
    match (spec.role, stem(&spec.name)) {
        (ParameterRole::JointOffset { .. }, _) => leg.angle_offset = v,
        (ParameterRole::LegDimension { .. }, "r") => leg.crank = Some(v),
        (ParameterRole::LegDimension { .. }, _) => leg.length = Some(v),
        _ => {}
    }
}
