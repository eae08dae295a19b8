//! `type = "six-hardpoint"`: six legs of variable length.

use std::any::Any;

use super::file_kind::{FileKind, Made, Source, Target};
use crate::conditions::Conditions;
use crate::files::error::FileError;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::reader::Reader;
use crate::files::mechanism::sections::LegEntry;
use crate::files::table::writer::number;
use crate::mechanism::{GeometryError, Leg, Mechanism, SixHardpoint, check_distinct_anchors};

/// Six legs of variable length, the kind of the paper.
pub(crate) const KIND: FileKind = FileKind {
    name: "six-hardpoint",
    label: "six legs of variable length",
    needed: &["length"],
    optional: &["length_offset", "stroke", "nominal"],
    parts: &["[[leg]]", "[mounting]"],
    points_move: true,
    example: Some(include_str!("../examples/six-hardpoint.toml")),
    read,
    write,
};

fn read(source: &Source<'_>, warned: &mut Vec<String>) -> Result<Made, FileError> {
    let Source { reader: r, document, convention, home, .. } = *source;
    let geometry = |cause| r.geometry(cause);
    KIND.check_keys(r, &document.legs)?;
    let (legs, nominal_legs) = read_legs(r, &document.legs)?;
    if legs.len() != 6 {
        return Err(geometry(GeometryError::LegCount { found: legs.len() }));
    }
    if !document.shared_anchors {
        check_distinct_anchors(&legs).map_err(|cause| equal_anchors(r, cause))?;
    }
    let tolerance = document.tolerance.as_ref().map(|t| r.tolerance(t)).transpose()?;
    let mechanism =
        SixHardpoint::new(&document.name, &legs, home.map(|q| convention.pose(&q)), tolerance).map_err(geometry)?;
    warned.extend(warnings(&mechanism, &legs));
    let nominal: Option<Box<dyn Mechanism>> = match nominal_legs.len() {
        0 => None,
        _ => {
            let home = document.nominal_home.as_ref();
            let home = home.map(|h| r.six("[nominal_home]", &h.position, &h.rotation)).transpose()?;
            let home = home.map(|q| convention.pose(&q));
            Some(Box::new(SixHardpoint::new(&document.name, &nominal_legs, home, None).map_err(geometry)?))
        }
    };
    Ok((Box::new(mechanism), nominal))
}

/// The legs, and those by which the controller turns poses into lengths if the file keeps them apart.
fn read_legs(r: &Reader<'_>, entries: &[LegEntry]) -> Result<(Vec<Leg>, Vec<Leg>), FileError> {
    let (mut legs, mut nominal) = (Vec::with_capacity(entries.len()), Vec::new());
    for (i, l) in entries.iter().enumerate() {
        let place = |key: &str| format!("leg {}, `{key}`", i + 1);
        let offset = |key: &str, v: f64| Ok(r.units.length.to_si(r.finite(&place(key), v)?));
        let leg = Leg {
            platform: r.point(&place("platform"), &l.platform)?,
            base: r.point(&place("base"), &l.base)?,
            // That it is stated was checked before.
            length: r.units.length.to_si(r.positive(&place("length"), l.length.unwrap_or(f64::NAN))?),
            length_offset: offset("length_offset", l.length_offset)?,
            stroke: l.stroke.map(|s| stroke(r, &place("stroke"), s)).transpose()?,
        };
        match (&l.nominal_platform, &l.nominal_base) {
            (Some(platform), Some(base)) => nominal.push(Leg {
                platform: r.point(&place("nominal_platform"), platform)?,
                base: r.point(&place("nominal_base"), base)?,
                length_offset: offset("nominal_length_offset", l.nominal_length_offset)?,
                ..leg.clone()
            }),
            (None, None) => {}
            _ => return Err(r.value(place("nominal_platform"), "and `nominal_base` belong together; state both")),
        }
        legs.push(leg);
    }
    if !nominal.is_empty() && nominal.len() != legs.len() {
        return Err(
            r.value("[[leg]]", "some legs have `nominal_platform` and `nominal_base`; state them for all or none")
        );
    }
    Ok((legs, nominal))
}

fn stroke(r: &Reader<'_>, place: &str, [from, to]: [f64; 2]) -> Result<[f64; 2], FileError> {
    if !(0.0 < from && from < to && to.is_finite()) {
        return Err(r.value(place, format!("[{from}, {to}] is not an interval; write [shortest, longest] length")));
    }
    Ok([r.units.length.to_si(from), r.units.length.to_si(to)])
}

/// Names the common point in the unit of the file.
fn equal_anchors(r: &Reader<'_>, cause: GeometryError) -> FileError {
    let GeometryError::EqualAnchors { first, second, body, x, y, z } = cause else {
        return r.geometry(cause);
    };
    let point = [x, y, z].map(|v| number(r.units.length.from_si(v))).join(", ");
    r.value(
        format!("legs {first} and {second}, `{body}`"),
        format!(
            "are the same point [{point}]; correct one of them, or state `shared_anchors = true` if the legs really \
             meet there"
        ),
    )
}

fn warnings(mechanism: &SixHardpoint, legs: &[Leg]) -> Vec<String> {
    let at = Conditions::unknown();
    let Ok(lengths) = mechanism.inverse(mechanism.values(), &mechanism.home(), &at) else { return Vec::new() };
    let mut warnings = Vec::new();
    let off = legs.iter().zip(&lengths).map(|(l, h)| (l.length - l.length_offset - h).abs()).fold(0.0, f64::max);
    if off > 1e-2 * legs[0].length {
        warnings.push(format!(
            "the leg lengths at the stated home differ from `length` by up to {:.3} mm; commanded lengths are absolute, so \
             check which of the two is meant",
            1e3 * off
        ));
    }
    for (i, (l, h)) in legs.iter().zip(&lengths).enumerate() {
        if let Some([from, to]) = l.stroke.filter(|[from, to]| h < from || h > to) {
            warnings.push(format!(
                "leg {}: its length at home, {:.3} mm, is outside its stroke {:.3} to {:.3} mm",
                i + 1,
                1e3 * h,
                1e3 * from,
                1e3 * to
            ));
        }
    }
    warnings
}

fn write(mechanism: &dyn Mechanism, target: &Target, document: &mut MechanismDocument) -> bool {
    let Some(six) = (mechanism as &dyn Any).downcast_ref::<SixHardpoint>() else { return false };
    let length = |v: f64| target.units.length.from_si(v);
    for (l, kept) in six.to_legs().iter().zip(&mut document.legs) {
        let offset = if kept.nominal_base.is_some() { kept.nominal_length_offset } else { kept.length_offset };
        *kept = LegEntry {
            platform: target.units.point(&l.platform),
            base: target.units.point(&l.base),
            length: Some(length(l.length)),
            length_offset: length(l.length_offset),
            stroke: l.stroke.map(|s| s.map(length)),
            nominal_platform: kept.nominal_platform.or(Some(kept.platform)),
            nominal_base: kept.nominal_base.or(Some(kept.base)),
            nominal_length_offset: offset,
            joint: kept.joint.take(),
            joint_reversed: kept.joint_reversed,
            ..LegEntry::default()
        };
    }
    document.home = Some(target.units.home(&target.convention, &six.home()));
    document.nominal_home = Some(target.units.home(&target.convention, &target.commanded_home));
    true
}
