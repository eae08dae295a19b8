//! From the words of a mechanism file to a [`Machine`]: units, ranges, and what does not fit together.

use std::path::Path;

use nalgebra::Vector3;

use crate::conditions::Conditions;
use crate::effect::Environment;
use crate::files::error::FileError;
use crate::files::machine::{Machine, POSE, SIX_HARDPOINT};
use crate::files::mechanism::document::{LegEntry, MechanismDocument, ToleranceSection};
use crate::files::mechanism::effects::{Effects, with_effects};
use crate::files::mechanism::environment::environment;
use crate::files::mechanism::kinds::{self, KINDS, check_keys};
use crate::files::mechanism::positioner::pose_positioner;
use crate::files::table::joint_columns::check_joints;
use crate::files::table::writer::number;
use crate::measurement::{Noise, TargetPoint};
use crate::mechanism::{GeometryError, Leg, Mechanism, SixHardpoint, Workspace, check_distinct_anchors};
use crate::pose::{PoseConvention, RotationOrder};
use crate::units::{Dimension, Unit};

/// Largest number of a file, far beyond any machine in any unit: products of several of them must not overflow.
pub(crate) const MOST: f64 = 1e30;

/// Reads numbers of one file into SI and names what is wrong with them.
pub(crate) struct Reader<'a> {
    pub(crate) path: &'a Path,
    pub(crate) length: Unit,
    pub(crate) angle: Unit,
}

impl<'a> Reader<'a> {
    /// A reader in the units of a document.
    pub(crate) fn of(path: &'a Path, document: &MechanismDocument) -> Result<Self, FileError> {
        let unit = |dimension, name: &str, place| {
            Unit::of(dimension, name).map_err(|cause| FileError::Unit { path: path.into(), place, cause })
        };
        Ok(Self {
            path,
            length: unit(Dimension::Length, &document.length_unit, "length_unit")?,
            angle: unit(Dimension::Angle, &document.angle_unit, "angle_unit")?,
        })
    }
}

impl Reader<'_> {
    pub(crate) fn value(&self, place: impl Into<String>, problem: impl Into<String>) -> FileError {
        FileError::Value { path: self.path.into(), place: place.into(), problem: problem.into() }
    }

    pub(crate) fn finite(&self, place: &str, v: f64) -> Result<f64, FileError> {
        match v {
            _ if !v.is_finite() => Err(self.value(place, format!("{v} is not a finite number; write a number"))),
            _ if v.abs() > MOST => {
                Err(self.value(place, format!("{v:e} is beyond {MOST:e}; correct the number or its unit")))
            }
            _ => Ok(v),
        }
    }

    pub(crate) fn not_negative(&self, place: &str, v: f64) -> Result<f64, FileError> {
        self.finite(place, v)?;
        if v < 0.0 { Err(self.value(place, format!("must not be negative, found {v}"))) } else { Ok(v) }
    }

    pub(crate) fn positive(&self, place: &str, v: f64) -> Result<f64, FileError> {
        self.finite(place, v)?;
        if v <= 0.0 { Err(self.value(place, format!("must be positive, found {v}"))) } else { Ok(v) }
    }

    /// A number of a section that may be left out.
    pub(crate) fn known(&self, place: &str, v: f64) -> Result<f64, FileError> {
        self.finite(place, v)?;
        match v {
            _ if v <= 0.0 => {
                let problem = format!("must be positive, found {v}; leave the section out if it is not known");
                Err(self.value(place, problem))
            }
            // Its reciprocal is a weight.
            _ if v < 1.0 / MOST => {
                let least = 1.0 / MOST;
                let problem = format!("{v:e} is below {least:e}; correct the number, or leave the section out");
                Err(self.value(place, problem))
            }
            _ => Ok(v),
        }
    }

    pub(crate) fn point(&self, place: &str, p: &[f64; 3]) -> Result<Vector3<f64>, FileError> {
        for v in p {
            self.finite(place, *v)?;
        }
        Ok(Vector3::from_column_slice(p).map(|v| self.length.to_si(v)))
    }

    /// Tolerance of an anchor and of a length; that of an anchor where none is stated.
    pub(crate) fn tolerance(&self, t: &ToleranceSection) -> Result<(f64, f64), FileError> {
        let anchor = self.length.to_si(self.known("[tolerance] anchor", t.anchor)?);
        let length = t.length.map(|v| self.known("[tolerance] length", v)).transpose()?;
        Ok((anchor, length.map_or(anchor, |v| self.length.to_si(v))))
    }

    fn unit_of_joints(&self, mechanism: &dyn Mechanism) -> Unit {
        let angles = mechanism.joints().first().is_some_and(|j| j.dimension == Dimension::Angle);
        if angles { self.angle } else { self.length }
    }

    pub(crate) fn six(&self, place: &str, position: &[f64; 3], rotation: &[f64; 3]) -> Result<[f64; 6], FileError> {
        let p = self.point(place, position)?;
        for v in rotation {
            self.finite(place, *v)?;
        }
        let r = rotation.map(|v| self.angle.to_si(v));
        Ok([p.x, p.y, p.z, r[0], r[1], r[2]])
    }
}

/// The legs, and those by which the controller turns poses into lengths if the file keeps them apart.
fn read_legs(r: &Reader<'_>, entries: &[LegEntry]) -> Result<(Vec<Leg>, Vec<Leg>), FileError> {
    let (mut legs, mut nominal) = (Vec::with_capacity(entries.len()), Vec::new());
    for (i, l) in entries.iter().enumerate() {
        let place = |key: &str| format!("leg {}, `{key}`", i + 1);
        let offset = |key: &str, v: f64| Ok(r.length.to_si(r.finite(&place(key), v)?));
        let leg = Leg {
            platform: r.point(&place("platform"), &l.platform)?,
            base: r.point(&place("base"), &l.base)?,
            // That it is stated was checked before.
            length: r.length.to_si(r.positive(&place("length"), l.length.unwrap_or(f64::NAN))?),
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

/// A mechanism and, if the file keeps them apart, the one by which the controller turns poses into joints.
pub(crate) type Made = (Box<dyn Mechanism>, Option<Box<dyn Mechanism>>);

/// Six legs of variable length.
fn six_hardpoint(
    r: &Reader<'_>,
    document: &MechanismDocument,
    convention: &PoseConvention,
    home: Option<[f64; 6]>,
    warned: &mut Vec<String>,
) -> Result<Made, FileError> {
    let geometry = |cause| FileError::Geometry { path: r.path.into(), cause };
    check_keys(r, SIX_HARDPOINT, &document.legs)?;
    let only_others = !document.cables.is_empty() || !document.nominal_legs.is_empty() || document.mounting.is_some();
    if only_others || document.identify.is_some() {
        let problem = "[[cable]], [[nominal_leg]], [mounting] and identify do not apply to six hardpoints; delete them";
        return Err(r.value("type", problem));
    }
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

/// A mechanism of another kind, made from its closure.
fn other_kind(
    r: &Reader<'_>,
    document: &MechanismDocument,
    convention: &PoseConvention,
    home: Option<[f64; 6]>,
    warned: &mut Vec<String>,
) -> Result<Made, FileError> {
    let kind = &document.kind;
    let Some(home) = home else {
        return Err(
            r.value("[home]", format!("is missing; a mechanism of type \"{kind}\" needs position and rotation"))
        );
    };
    let home = convention.pose(&home);
    let drawn = kinds::read(r, document, &document.legs, &document.cables, home)?;
    if convention.order != RotationOrder::default() && drawn.controlled() != [true; 6] {
        let problem = format!("must be \"zyx\" for type \"{kind}\", whose joints control some of these angles only");
        return Err(r.value("rotation_order", problem));
    }
    let moved = home.motion_to(&drawn.home());
    if moved.amax() > 1e-4 {
        let (length, turn) = (moved.fixed_rows::<3>(0).norm(), moved.fixed_rows::<3>(3).norm());
        warned.push(format!(
            "[home]: the joints do not control all of its coordinates; home lies {:.3} {} and {:.4} {} from there",
            r.length.from_si(length),
            r.length.name,
            r.angle.from_si(turn),
            r.angle.name
        ));
    }
    let mechanism = kinds::mounted(r, document, drawn)?;
    if mechanism.controlled() != [true; 6] && convention.pivot != Vector3::zeros() {
        let problem = format!("must be absent for type \"{kind}\"; put the origin of the platform frame there");
        return Err(r.value("pivot", problem));
    }
    if document.nominal_legs.is_empty() && !document.nominal_cables.is_empty() {
        return Err(r.value("[[nominal_cable]]", "belongs to [[nominal_leg]]; state both, or neither"));
    }
    let nominal = match document.nominal_legs.is_empty() {
        true => None,
        false => {
            let home = match &document.nominal_home {
                Some(h) => convention.pose(&r.six("[nominal_home]", &h.position, &h.rotation)?),
                None => home,
            };
            let cables = if document.nominal_cables.is_empty() { &document.cables } else { &document.nominal_cables };
            Some(kinds::read(r, document, &document.nominal_legs, cables, home)?)
        }
    };
    let at_home = mechanism.inverse(mechanism.values(), &mechanism.home(), &Conditions::unknown());
    for (spec, value) in mechanism.joints().iter().zip(at_home.iter().flatten()) {
        if let Some([from, to]) = spec.stroke.filter(|[from, to]| value < from || value > to) {
            let unit = if spec.dimension == Dimension::Angle { r.angle } else { r.length };
            let [value, from, to] = [*value, from, to].map(|v| unit.from_si(v));
            let name = &spec.name;
            warned.push(format!(
                "{name} is {value:.3} {0} at home, outside its stroke {from:.3} to {to:.3} {0}",
                unit.name
            ));
        }
    }
    Ok((mechanism, nominal))
}

/// Builds the machine of a document.
pub(crate) fn build(r: &Reader<'_>, document: MechanismDocument) -> Result<Machine, FileError> {
    let path = r.path;
    let kind = document.kind.as_str();
    let kinds = || std::iter::once(SIX_HARDPOINT).chain(KINDS).chain([POSE]);
    if !kinds().any(|k| k == kind) {
        let known: Vec<String> = kinds().map(|k| format!("\"{k}\"")).collect();
        return Err(r.value("type", format!("'{kind}' is not a kind of mechanism; use one of {}", known.join(", "))));
    }
    let pivot = r.point("pivot", &document.pivot)?;
    let convention = PoseConvention { order: document.rotation_order, pivot };
    let home = document.home.as_ref().map(|h| r.six("[home]", &h.position, &h.rotation)).transpose()?;
    let make = match kind {
        SIX_HARDPOINT => six_hardpoint,
        POSE => pose_positioner,
        _ => other_kind,
    };
    if kind != POSE && document.offset.is_some() {
        return Err(r.value("[offset]", format!("does not apply to type \"{kind}\"; delete it")));
    }
    let mut warnings = Vec::new();
    let (mechanism, nominal) = make(r, &document, &convention, home, &mut warnings)?;
    let workspace = match &document.workspace {
        None => None,
        Some(w) => {
            for v in w.position.iter().chain(&w.rotation) {
                r.not_negative("[workspace]", *v)?;
            }
            let mut half = r.six("[workspace]", &w.position, &w.rotation)?;
            // In the frames of a measurement the coordinates are mixed, and each may follow from the others.
            if document.mounting.is_none() {
                for (k, name) in ["x", "y", "z", "rx", "ry", "rz"].iter().enumerate() {
                    if half[k] > 0.0 && !mechanism.controlled()[k] {
                        half[k] = 0.0;
                        warnings.push(format!("[workspace]: the joints do not control {name}; write 0 there"));
                    }
                }
            }
            Some(Workspace { convention, centre: convention.coordinates(&mechanism.home()), half })
        }
    };
    let noise = match &document.noise {
        None => None,
        Some(n) => Some(Noise {
            position: r.length.to_si(r.known("[noise] position", n.position)?),
            rotation: r.angle.to_si(r.known("[noise] rotation", n.rotation)?),
            joint: r.unit_of_joints(mechanism.as_ref()).to_si(r.not_negative("[noise] joint", n.joint)?),
            known: true,
        }),
    };
    let mut targets = Vec::new();
    for t in &document.targets {
        let place = format!("[[target]] '{}'", t.name);
        if targets.iter().any(|k: &TargetPoint| k.name == t.name) {
            return Err(r.value(place, "is stated twice; give each target its own name"));
        }
        let platform = t.platform.as_ref().map(|p| r.point(&place, p)).transpose()?;
        targets.push(TargetPoint { name: t.name.clone(), platform });
    }
    let contact = document.plane.as_ref().map(|p| p.read(r)).transpose()?.unwrap_or_default();
    let commander = nominal.as_deref().unwrap_or(mechanism.as_ref());
    let home_joints = commander.inverse(commander.values(), &commander.home(), &Conditions::unknown()).ok();
    let environment = Environment { home_joints, ..environment(r, &document)? };
    let Effects { mechanism, instrument, environment } = with_effects(r, &document, mechanism, environment)?;
    warnings.extend(check_joints(r, &document)?);
    Ok(Machine {
        path: path.into(),
        mechanism,
        nominal,
        convention,
        workspace,
        noise,
        targets,
        contact,
        environment,
        instrument,
        length_unit: r.length,
        angle_unit: r.angle,
        warnings,
        inputs: vec![path.into()],
        document,
    })
}

fn stroke(r: &Reader<'_>, place: &str, [from, to]: [f64; 2]) -> Result<[f64; 2], FileError> {
    if !(0.0 < from && from < to && to.is_finite()) {
        return Err(r.value(place, format!("[{from}, {to}] is not an interval; write [shortest, longest] length")));
    }
    Ok([r.length.to_si(from), r.length.to_si(to)])
}

/// Names the common point in the unit of the file.
fn equal_anchors(r: &Reader<'_>, cause: GeometryError) -> FileError {
    let GeometryError::EqualAnchors { first, second, body, x, y, z } = cause else {
        return FileError::Geometry { path: r.path.into(), cause };
    };
    let point = [x, y, z].map(|v| number(r.length.from_si(v))).join(", ");
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
