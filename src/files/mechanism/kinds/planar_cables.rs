//! `type = "planar-cables"`: a platform in a plane, held by cables.

use super::closure_kind::{self, Drawing};
use super::file_kind::FileKind;
use super::row::{Row, each};
use crate::files::error::FileError;
use crate::files::mechanism::document::MechanismDocument;
use crate::mechanism::closure::ClosureMechanism;
use crate::mechanism::kinds::{Cable, PlanarCables, Segment};
use crate::mechanism::{ParameterRole, ParameterSpec};
use crate::units::Dimension;

/// Cables that hold a platform in a plane.
pub(super) const KIND: FileKind = FileKind {
    name: "planar-cables",
    label: "cables that hold a platform in a plane",
    needed: &[],
    optional: &[],
    parts: &["[[leg]]", "[[cable]]", "[[nominal_leg]]", "[[nominal_cable]]", "[mounting]", "identify"],
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
    let mut read = Vec::with_capacity(cables.len());
    for (i, c) in cables.iter().enumerate() {
        let at = Row { r, section: "cable", row: i + 1 };
        let segment = |k: &usize| {
            let problem = || {
                r.value(
                    at.place("segments"),
                    format!(
                        "{k} is not a leg; legs are numbered from 1 to \
                                     {}",
                        legs.len()
                    ),
                )
            };
            k.checked_sub(1).filter(|k| *k < legs.len()).ok_or_else(problem)
        };
        let dimension = if c.drum.is_some() { Dimension::Angle } else { Dimension::Length };
        read.push(Cable {
            segments: c.segments.iter().map(segment).collect::<Result<_, _>>()?,
            drum: c.drum.map(|v| at.positive("drum", Some(v))).transpose()?,
            offset: r.units.length.to_si(at.finite("length_offset", c.length_offset)?),
            stroke: at.stroke(c.stroke, dimension)?,
        });
    }
    PlanarCables::new(drawing.name, &segments, &read, home, tolerances).map_err(|cause| r.geometry(cause))
}

fn put(document: &mut MechanismDocument, spec: &ParameterSpec, v: f64) {
    let Some(cable) = spec.role.leg().and_then(|cable| document.cables.get_mut(cable)) else { return };
    match spec.role {
        ParameterRole::JointScale { .. } => cable.drum = Some(v),
        ParameterRole::JointOffset { .. } => cable.length_offset = v,
        _ => {}
    }
}
