//! What the kinds that are made from a closure have in common: home, mounting, nominal legs, and which parameters are
//! identified.

use std::any::Any;

use nalgebra::Vector3;

use super::file_kind::{FileKind, Made, Source, Target};
use crate::conditions::Conditions;
use crate::files::error::FileError;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::reader::Reader;
use crate::files::mechanism::sections::{CableEntry, DeltaSection, LegEntry, PerTowerEntry};
use crate::mechanism::closure::{Closure, ClosureMechanism};
use crate::mechanism::kinds::{PerTower, Tolerances};
use crate::mechanism::{Mechanism, ParameterRole, ParameterSpec};
use crate::pose::{Pose, RotationOrder};

/// Parts of the file that every such kind may have.
pub(super) const PARTS: &[&str] = &["[[leg]]", "[[nominal_leg]]", "[mounting]", "identify"];

/// What one kind is drawn from, in the frames of its drawing.
pub(super) struct Drawing<'a> {
    pub(super) r: &'a Reader<'a>,
    pub(super) name: &'a str,
    pub(super) legs: &'a [LegEntry],
    pub(super) cables: &'a [CableEntry],
    pub(super) delta: Option<&'a DeltaSection>,
    pub(super) home: Pose,
    pub(super) tolerances: Option<Tolerances>,
}

/// Makes the closure of one kind from its drawing.
pub(super) type Make<C> = fn(&Drawing<'_>) -> Result<ClosureMechanism<C>, FileError>;

/// Reads a mechanism that is made from a closure.
pub(super) fn read<C: Closure>(
    kind: &FileKind,
    make: Make<C>,
    source: &Source<'_>,
    warned: &mut Vec<String>,
) -> Result<Made, FileError> {
    let Source { reader: r, document, convention, home, .. } = *source;
    let name = kind.name;
    let Some(home) = home else {
        return Err(
            r.value("[home]", format!("is missing; a mechanism of type \"{name}\" needs position and rotation"))
        );
    };
    let home = convention.pose(&home);
    let draw = |legs, cables, delta, home| {
        kind.check_keys(r, legs)?;
        let tolerances = tolerances(r, document)?;
        let drawing = Drawing { r, name: &document.name, legs, cables, delta, home, tolerances };
        identified(r, document, &make(&drawing)?)
    };
    let drawn = draw(&document.legs, &document.cables, document.delta.as_ref(), home)?;
    if convention.order != RotationOrder::default() && drawn.controlled() != [true; 6] {
        let problem = format!("must be \"zyx\" for type \"{name}\", whose joints control some of these angles only");
        return Err(r.value("rotation_order", problem));
    }
    warned.extend(moved_home(r, &home, &drawn.home()));
    let mechanism = drawn;
    if mechanism.controlled() != [true; 6] && convention.pivot != Vector3::zeros() {
        let problem = format!("must be absent for type \"{name}\"; put the origin of the platform frame there");
        return Err(r.value("pivot", problem));
    }
    if document.nominal_legs.is_empty() && !document.nominal_cables.is_empty() {
        return Err(r.value("[[nominal_cable]]", "belongs to [[nominal_leg]]; state both, or neither"));
    }
    let nominal = match document.nominal_legs.is_empty() && document.nominal_delta.is_none() {
        true => None,
        false => {
            let home = match &document.nominal_home {
                Some(h) => convention.pose(&r.six("[nominal_home]", &h.position, &h.rotation)?),
                None => home,
            };
            let cables = if document.nominal_cables.is_empty() { &document.cables } else { &document.nominal_cables };
            Some(draw(&document.nominal_legs, cables, document.nominal_delta.as_ref(), home)?)
        }
    };
    warned.extend(outside_strokes(r, mechanism.as_ref()));
    Ok((mechanism, nominal))
}

/// Says that the joints put home elsewhere than the file does.
fn moved_home(r: &Reader<'_>, stated: &Pose, drawn: &Pose) -> Option<String> {
    let moved = stated.motion_to(drawn);
    let (length, turn) = (moved.fixed_rows::<3>(0).norm(), moved.fixed_rows::<3>(3).norm());
    (moved.amax() > 1e-4).then(|| {
        format!(
            "[home]: the joints do not control all of its coordinates; the pose that closes the loops lies {:.3} {} and {:.4} {} from the stated home",
            r.units.length.from_si(length),
            r.units.length.name,
            r.units.angle.from_si(turn),
            r.units.angle.name
        )
    })
}

/// Says which joints are outside their strokes at home.
fn outside_strokes(r: &Reader<'_>, mechanism: &dyn Mechanism) -> Vec<String> {
    let at_home = mechanism.inverse(mechanism.values(), &mechanism.home(), &Conditions::unknown());
    let mut warnings = Vec::new();
    for (spec, value) in mechanism.joints().iter().zip(at_home.iter().flatten()) {
        if let Some([from, to]) = spec.stroke.filter(|[from, to]| value < from || value > to) {
            let unit = r.units.of(spec.dimension);
            let [value, from, to] = [*value, from, to].map(|v| unit.from_si(v));
            let name = &spec.name;
            warnings.push(format!(
                "{name} is {value:.3} {0} at home, outside its stroke {from:.3} to {to:.3} {0}",
                unit.name
            ));
        }
    }
    warnings
}

/// The tolerances of a document, SI.
fn tolerances(r: &Reader<'_>, document: &MechanismDocument) -> Result<Option<Tolerances>, FileError> {
    let Some(t) = &document.tolerance else { return Ok(None) };
    let (anchor, length) = r.tolerance(t)?;
    let angle = t.angle.map(|v| r.known("[tolerance] angle", v)).transpose()?;
    let radii = |point: fn(&LegEntry) -> &[f64; 3]| {
        let n = document.legs.len().max(1) as f64;
        document.legs.iter().map(|l| r.units.length.to_si(Vector3::from_column_slice(point(l)).norm())).sum::<f64>() / n
    };
    let towers = document.delta.map(|d| r.units.length.to_si(per_tower(d.tower_radius).of(0)));
    let of_legs = || Some(radii(|l| &l.platform)).filter(|v| *v > 0.0).unwrap_or_else(|| radii(|l| &l.base));
    let radius = towers.unwrap_or_else(of_legs);
    Ok(Some(Tolerances {
        anchor,
        length,
        angle: angle.map_or(anchor / radius.max(f64::MIN_POSITIVE), |v| r.units.angle.to_si(v)),
    }))
}

/// Numbers of towers as a file has them, in its units.
pub(super) fn per_tower(entry: PerTowerEntry) -> PerTower {
    match entry {
        PerTowerEntry::Shared(value) => PerTower::Shared(value),
        PerTowerEntry::Each(values) => PerTower::Each(values),
    }
}

/// The mechanism with the parameters that `identify` asks for.
fn identified<C: Closure>(
    r: &Reader<'_>,
    document: &MechanismDocument,
    made: &ClosureMechanism<C>,
) -> Result<Box<dyn Mechanism>, FileError> {
    let mut stems: Vec<&str> = made.outline().parameters.iter().map(|p| stem(&p.name)).collect();
    stems.sort_unstable();
    stems.dedup();
    if let Some(unknown) = document.identify.iter().flatten().find(|s| !stems.contains(&s.as_str())) {
        let problem = format!("'{unknown}' is not a parameter; those of this kind are {}", stems.join(", "));
        return Err(r.value("identify", problem));
    }
    if document.identify.as_ref().is_some_and(Vec::is_empty) {
        return Err(r.value("identify", "names no parameter; name some, or delete it to identify all"));
    }
    let wanted =
        |spec: &ParameterSpec| document.identify.as_ref().is_none_or(|w| w.iter().any(|s| s == stem(&spec.name)));
    Ok(Box::new(made.identifying(wanted).map_err(|cause| r.geometry(cause))?))
}

/// The name of a parameter without the number of its leg.
pub(super) fn stem(name: &str) -> &str {
    name.trim_end_matches(|c: char| c.is_ascii_digit())
}

/// Puts the value of a parameter that is no coordinate of a point into the entries of a file, in its units.
pub(super) type Put = fn(&mut MechanismDocument, &ParameterSpec, f64);

/// Writes a mechanism that is made from this closure. It keeps the frames of its drawing and is mounted in those of the
/// measurement.
pub(super) fn write<C: Closure>(
    mechanism: &dyn Mechanism,
    target: &Target,
    document: &mut MechanismDocument,
    put: Put,
) -> bool {
    let Some(made) = (mechanism as &dyn Any).downcast_ref::<ClosureMechanism<C>>() else { return false };
    if document.nominal_legs.is_empty() && document.nominal_delta.is_none() {
        document.nominal_legs = document.legs.clone();
        document.nominal_cables = document.cables.clone();
        document.nominal_delta = document.delta;
        document.nominal_home = document.home.clone();
    }
    for (spec, value) in made.outline().parameters.iter().zip(made.all_values()) {
        let v = target.units.of(spec.dimension).from_si(*value);
        let leg = spec.role.leg().and_then(|leg| document.legs.get_mut(leg));
        match (spec.role, leg) {
            (ParameterRole::PlatformPoint { axis, .. }, Some(leg)) => leg.platform[axis.index()] = v,
            (ParameterRole::BasePoint { axis, .. }, Some(leg)) => leg.base[axis.index()] = v,
            _ => put(document, spec, v),
        }
    }
    document.home = Some(target.units.home(&target.convention, &made.own_home()));
    true
}
