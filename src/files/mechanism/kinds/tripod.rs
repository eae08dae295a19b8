//! `type = "tripod-3rps"`: three legs on hinges.

use super::closure_kind::{self, Drawing, PARTS, stem};
use super::file_kind::FileKind;
use super::row::each;
use crate::files::error::FileError;
use crate::files::mechanism::document::MechanismDocument;
use crate::mechanism::closure::ClosureMechanism;
use crate::mechanism::kinds::{HingedLeg, Tripod};
use crate::mechanism::{ParameterRole, ParameterSpec};
use crate::units::Dimension;

/// Three legs of variable length on hinges.
pub(super) const KIND: FileKind = FileKind {
    name: "tripod-3rps",
    label: "three legs of variable length on hinges",
    needed: &["axis"],
    optional: &["length_offset", "hinge_tilt", "stroke"],
    parts: PARTS,
    points_move: false,
    example: Some(include_str!("../examples/tripod-3rps.toml")),
    read: |source, warned| closure_kind::read::<Tripod>(&KIND, draw, source, warned),
    write: |mechanism, target, document| closure_kind::write::<Tripod>(mechanism, target, document, put),
};

fn draw(drawing: &Drawing<'_>) -> Result<ClosureMechanism<Tripod>, FileError> {
    let Drawing { r, legs, home, tolerances, .. } = *drawing;
    let hinged = each(r, legs, |at, l| {
        let tilt = [at.finite("hinge_tilt", l.hinge_tilt[0])?, at.finite("hinge_tilt", l.hinge_tilt[1])?];
        Ok(HingedLeg {
            platform: at.point("platform", &l.platform)?,
            base: at.point("base", &l.base)?,
            axis: at.direction("axis", l.axis)?,
            tilt: tilt.map(|v| r.units.angle.to_si(v)),
            offset: r.units.length.to_si(at.finite("length_offset", l.length_offset)?),
            stroke: at.stroke(l.stroke, Dimension::Length)?,
        })
    })?;
    Tripod::new(drawing.name, &hinged, home, tolerances).map_err(|cause| r.geometry(cause))
}

fn put(document: &mut MechanismDocument, spec: &ParameterSpec, v: f64) {
    let Some(leg) = spec.role.leg().and_then(|leg| document.legs.get_mut(leg)) else { return };
    match (spec.role, stem(&spec.name)) {
        (ParameterRole::JointOffset { .. }, _) => leg.length_offset = v,
        (ParameterRole::Direction { .. }, "m") => leg.hinge_tilt[0] = v,
        (ParameterRole::Direction { .. }, "n") => leg.hinge_tilt[1] = v,
        _ => {}
    }
}
