//! `type = "cables"`: a platform or a point in space, held by cables.

use nalgebra::Vector3;

use super::closure_kind::{self, Drawing};
use super::file_kind::FileKind;
use super::planar_cables::{CABLE_PARTS, put, read_cables};
use super::row::each;
use crate::files::error::FileError;
use crate::mechanism::closure::ClosureMechanism;
use crate::mechanism::kinds::{Cables, Pulley, Segment};

/// Cables that hold a platform or a point in space.
pub(super) const KIND: FileKind = FileKind {
    name: "cables",
    label: "cables that hold a platform or a point in space",
    needed: &[],
    optional: &["pulley", "swivel"],
    parts: CABLE_PARTS,
    points_move: false,
    example: Some(include_str!("../examples/cables.toml")),
    read: |source, warned| closure_kind::read::<Cables>(&KIND, draw, source, warned),
    write: |mechanism, target, document| closure_kind::write::<Cables>(mechanism, target, document, put),
};

fn draw(drawing: &Drawing<'_>) -> Result<ClosureMechanism<Cables>, FileError> {
    let Drawing { r, legs, cables, home, tolerances, .. } = *drawing;
    let segments = each(r, legs, |at, l| {
        let pulley = match (l.pulley, l.swivel) {
            (None, Some(_)) => return Err(r.value(at.place("swivel"), "is stated without `pulley`; add its radius")),
            (None, None) => None,
            (Some(_), swivel) => Some(Pulley {
                radius: at.positive("pulley", l.pulley)?,
                swivel: swivel.map_or(Ok(Vector3::z()), |v| at.direction("swivel", Some(v)))?,
            }),
        };
        Ok((Segment { platform: at.point("platform", &l.platform)?, base: at.point("base", &l.base)? }, pulley))
    })?;
    let cables = read_cables(r, legs.len(), cables)?;
    Cables::new(drawing.name, &segments, &cables, home, tolerances).map_err(|cause| r.geometry(cause))
}
