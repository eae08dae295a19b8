//! `type = "rotary-delta"`: three cranks that turn, with two rods each to the platform.

use super::closure_kind::{self, Drawing, PARTS, stem};
use super::file_kind::FileKind;
use super::rotary_stewart::cranked;
use super::row::each;
use crate::files::error::FileError;
use crate::files::mechanism::document::MechanismDocument;
use crate::mechanism::closure::ClosureMechanism;
use crate::mechanism::kinds::{RodsOnCranks, RotaryDelta};
use crate::mechanism::{ParameterRole, ParameterSpec};

/// Six rods, two on each of three cranks that turn.
pub(super) const KIND: FileKind = FileKind {
    name: "rotary-delta",
    label: "six rods, two on each of three cranks that turn",
    needed: &["length", "crank", "axis", "zero", "motor"],
    optional: &["angle_offset", "stroke"],
    parts: PARTS,
    points_move: false,
    example: Some(include_str!("../examples/rotary-delta.toml")),
    read: |source, warned| closure_kind::read::<RodsOnCranks>(&KIND, draw, source, warned),
    write: |mechanism, target, document| closure_kind::write::<RodsOnCranks>(mechanism, target, document, put),
};

fn draw(drawing: &Drawing<'_>) -> Result<ClosureMechanism<RodsOnCranks>, FileError> {
    let Drawing { r, legs, home, tolerances, .. } = *drawing;
    let rods = each(r, legs, |at, l| Ok((at.number("motor", l.motor, 3)?, cranked(at, l)?)))?;
    RotaryDelta::new(drawing.name, &rods, home, tolerances).map_err(|cause| r.geometry(cause))
}

/// What belongs to a crank stands at both of its rods.
fn put(document: &mut MechanismDocument, spec: &ParameterSpec, v: f64) {
    let Some(number) = spec.role.leg() else { return };
    let on_motor = document.legs.iter_mut().filter(|leg| leg.motor == Some(number + 1));
    match (spec.role, stem(&spec.name)) {
        (ParameterRole::JointOffset { .. }, _) => on_motor.for_each(|leg| leg.angle_offset = v),
        (ParameterRole::LegDimension { .. }, "r") => on_motor.for_each(|leg| leg.crank = Some(v)),
        (ParameterRole::LegDimension { .. }, _) => {
            if let Some(leg) = document.legs.get_mut(number) {
                leg.length = Some(v);
            }
        }
        _ => {}
    }
}
