//! `type = "planar-cables"`: a platform in a plane, held by cables.

use super::closure_kind::{self, Drawing};
use super::file_kind::FileKind;
use super::row::{Row, each};
use crate::files::error::FileError;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::reader::Reader;
use crate::files::mechanism::sections::CableEntry;
use crate::mechanism::closure::ClosureMechanism;
use crate::mechanism::kinds::{Cable, PlanarCables, Segment};
use crate::mechanism::{ParameterRole, ParameterSpec};
use crate::units::Dimension;

/// Parts of the file of a machine with cables.
pub(super) const CABLE_PARTS: &[&str] =
    &["[[leg]]", "[[cable]]", "[[nominal_leg]]", "[[nominal_cable]]", "[mounting]", "identify"];

/// Cables that hold a platform in a plane.
pub(super) const KIND: FileKind = FileKind {
    name: "planar-cables",
    label: "cables that hold a platform in a plane",
    needed: &[],
    optional: &[],
    parts: CABLE_PARTS,
    points_move: false,
    example: Some(include_str!("../examples/planar-cables.toml")),
    read: |source, warned| closure_kind::read::<PlanarCables>(&KIND, draw, source, warned),
    write: |mechanism, target, document| closure_kind::write::<PlanarCables>(mechanism, target, document, put),
};

fn draw(drawing: &Drawing<'_>) -> Result<ClosureMechanism<PlanarCables>, FileError> {
    let Drawing { r, legs, cables, home, tolerances, .. } = *drawing;
    let segments = each(r, legs, |at, l| {
        Ok(Segment { platform: at.point("platform", &l.platform)?, base: at.point("base", &l.base)? })
    })?;
    let read = read_cables(r, legs.len(), cables)?;
    PlanarCables::new(drawing.name, &segments, &read, home, tolerances).map_err(|cause| r.geometry(cause))
}

/// The cables of a file, which run along so many segments.
pub(super) fn read_cables(r: &Reader<'_>, legs: usize, cables: &[CableEntry]) -> Result<Vec<Cable>, FileError> {
    let one = |(i, c): (usize, &CableEntry)| {
        let at = Row { r, section: "cable", row: i + 1 };
        let segment = |k: &usize| {
            let problem = format!("{k} is not a leg; legs are numbered from 1 to {legs}");
            k.checked_sub(1).filter(|k| *k < legs).ok_or_else(|| r.value(at.place("segments"), problem))
        };
        if c.build_up.is_some() && c.drum.is_none() {
            return Err(r.value(at.place("build_up"), "is stated without `drum`; a cable without a drum does not wind"));
        }
        let dimension = if c.drum.is_some() { Dimension::Angle } else { Dimension::Length };
        let length = |key: &str, v: f64| Ok::<_, FileError>(r.units.length.to_si(at.finite(key, v)?));
        Ok(Cable {
            segments: c.segments.iter().map(segment).collect::<Result<_, _>>()?,
            drum: c.drum.map(|v| at.positive("drum", Some(v))).transpose()?,
            build_up: c.build_up.map(|v| length("build_up", v)).transpose()?,
            offset: length("length_offset", c.length_offset)?,
            stroke: at.stroke(c.stroke, dimension)?,
        })
    };
    cables.iter().enumerate().map(one).collect()
}

/// Writes what belongs to a cable.
pub(super) fn put(document: &mut MechanismDocument, spec: &ParameterSpec, v: f64) {
    let Some(cable) = spec.role.leg().and_then(|cable| document.cables.get_mut(cable)) else { return };
    match spec.role {
        ParameterRole::JointScale { .. } => cable.drum = Some(v),
        ParameterRole::LegDimension { .. } => cable.build_up = Some(v),
        ParameterRole::JointOffset { .. } => cable.length_offset = v,
        _ => {}
    }
}
