//! `type = "linear-delta"`: six rods on three carriages, or `[delta]` with the numbers of the firmware.

use super::closure_kind::{self, Drawing, per_tower, stem};
use super::file_kind::{FileKind, Made, Source, Target};
use super::row::{Row, each};
use crate::files::error::FileError;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::reader::Reader;
use crate::files::mechanism::sections::{DeltaSection, LegEntry, PerTowerEntry};
use crate::mechanism::closure::ClosureMechanism;
use crate::mechanism::kinds::{LinearDelta, PerTower, Rod, RodsOnRails, TiedDelta, Towers};
use crate::mechanism::{Mechanism, ParameterRole, ParameterSpec};
use crate::units::Dimension;

/// Six rods on three carriages, each on a rail.
pub(super) const KIND: FileKind = FileKind {
    name: "linear-delta",
    label: "six rods on three carriages, each on a rail",
    needed: &["length", "carriage", "rail"],
    optional: &["stroke"],
    parts: &["[[leg]]", "[[nominal_leg]]", "[delta]", "[nominal_delta]", "[mounting]", "identify"],
    points_move: false,
    example: Some(include_str!("../examples/linear-delta.toml")),
    read,
    write,
};

fn read(source: &Source<'_>, warned: &mut Vec<String>) -> Result<Made, FileError> {
    let (r, document) = (source.reader, source.document);
    match document.delta {
        Some(_) if !document.legs.is_empty() => {
            Err(r
                .value("[delta]", "stands beside [[leg]]; state the rods one by one, or [delta], and delete the other"))
        }
        Some(_) => closure_kind::read::<TiedDelta>(&KIND, draw_tied, source, warned),
        None => closure_kind::read::<RodsOnRails>(&KIND, draw, source, warned),
    }
}

fn write(mechanism: &dyn Mechanism, target: &Target, document: &mut MechanismDocument) -> bool {
    closure_kind::write::<RodsOnRails>(mechanism, target, document, put)
        || closure_kind::write::<TiedDelta>(mechanism, target, document, put_tied)
}

/// A rod on one of so many carriages.
pub(super) fn rod(at: &Row<'_>, l: &LegEntry, carriage: usize) -> Result<Rod, FileError> {
    Ok(Rod {
        platform: at.point("platform", &l.platform)?,
        base: at.point("base", &l.base)?,
        length: at.positive("length", l.length)?,
        carriage,
        rail: at.direction("rail", l.rail)?,
        stroke: at.stroke(l.stroke, Dimension::Length)?,
    })
}

fn draw(drawing: &Drawing<'_>) -> Result<ClosureMechanism<RodsOnRails>, FileError> {
    let Drawing { r, legs, home, tolerances, .. } = *drawing;
    let rods = each(r, legs, |at, l| rod(at, l, at.number("carriage", l.carriage, 3)?))?;
    LinearDelta::new(drawing.name, &rods, home, tolerances).map_err(|cause| r.geometry(cause))
}

/// Writes the length of a rod.
pub(super) fn put(document: &mut MechanismDocument, spec: &ParameterSpec, v: f64) {
    let Some(leg) = spec.role.leg().and_then(|leg| document.legs.get_mut(leg)) else { return };
    if let ParameterRole::LegDimension { .. } = spec.role {
        leg.length = Some(v);
    }
}

fn draw_tied(drawing: &Drawing<'_>) -> Result<ClosureMechanism<TiedDelta>, FileError> {
    let Drawing { r, home, tolerances, .. } = *drawing;
    let Some(d) = drawing.delta else {
        return Err(r.value("[nominal_delta]", "is missing beside [delta]; state both, or only [delta]"));
    };
    let lengths = |key: &str, entry: PerTowerEntry| -> Result<PerTower, FileError> {
        let read = |v: f64| Ok(r.units.length.to_si(r.finite(&format!("[delta] {key}"), v)?));
        Ok(match per_tower(entry) {
            PerTower::Shared(v) => PerTower::Shared(read(v)?),
            PerTower::Each([a, b, c]) => PerTower::Each([read(a)?, read(b)?, read(c)?]),
        })
    };
    let [a, b, c] = d.tower_angle;
    let angle = |v: f64| Ok::<_, FileError>(r.units.angle.to_si(r.finite("[delta] tower_angle", v)?));
    let towers = Towers {
        endstop: lengths("endstop", d.endstop)?,
        radius: lengths("tower_radius", d.tower_radius)?,
        angle: [angle(a)?, angle(b)?, angle(c)?],
        arm: lengths("arm", d.arm)?,
        stroke: stroke(r, d)?,
    };
    TiedDelta::new(drawing.name, &towers, home, tolerances).map_err(|cause| r.geometry(cause))
}

fn stroke(r: &Reader<'_>, d: &DeltaSection) -> Result<Option<[f64; 2]>, FileError> {
    Row { r, section: "delta", row: 1 }.stroke(d.stroke, Dimension::Length)
}

fn put_tied(document: &mut MechanismDocument, spec: &ParameterSpec, v: f64) {
    let Some(delta) = document.delta.as_mut() else { return };
    let entry = match stem(&spec.name) {
        "endstop" => &mut delta.endstop,
        "tower_radius" => &mut delta.tower_radius,
        "arm" => &mut delta.arm,
        _ => {
            if let Some(angle) = spec.role.leg().and_then(|leg| delta.tower_angle.get_mut(leg)) {
                *angle = v;
            }
            return;
        }
    };
    match (entry, spec.role.leg()) {
        (PerTowerEntry::Each(values), Some(leg)) => {
            if let Some(value) = values.get_mut(leg) {
                *value = v;
            }
        }
        (shared, _) => *shared = PerTowerEntry::Shared(v),
    }
}
