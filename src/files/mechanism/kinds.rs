//! The kinds of mechanism that a file may state beside six hardpoints, read and written.
//!
//! | `type` | `[[leg]]` needs | may have |
//! |---|---|---|
//! | `rotary-stewart` | `platform base length crank axis zero` | `angle_offset stroke` |
//! | `linear-delta` | `platform base length carriage rail` | `stroke` |
//! | `tripod-3rps` | `platform base axis` | `length_offset hinge_tilt stroke` |
//! | `planar-cables` | `platform base`, and `[[cable]] segments` | `drum length_offset stroke` of a cable |

use std::any::Any;

use nalgebra::Vector3;

use crate::files::error::FileError;
use crate::files::mechanism::document::{CableEntry, LegEntry, MechanismDocument};
use crate::files::mechanism::read::Reader;
use crate::mechanism::closure::{Closure, ClosureMechanism};
use crate::mechanism::kinds::{
    Cable, CrankLeg, HingedLeg, LinearDelta, PlanarCables, Rod, RotaryStewart, Segment, Tolerances, Tripod,
};
use crate::mechanism::{GeometryError, Mechanism, ParameterRole, ParameterSpec};
use crate::pose::Pose;
use crate::units::Dimension;

/// Their names in files.
pub(crate) const KINDS: [&str; 4] = ["rotary-stewart", "linear-delta", "tripod-3rps", "planar-cables"];

/// Keys of a leg beside `platform` and `base` that a kind needs, and those that it may have.
fn keys(kind: &str) -> (&'static [&'static str], &'static [&'static str]) {
    match kind {
        "rotary-stewart" => (&["length", "crank", "axis", "zero"], &["angle_offset", "stroke"]),
        "linear-delta" => (&["length", "carriage", "rail"], &["stroke"]),
        "tripod-3rps" => (&["axis"], &["length_offset", "hinge_tilt", "stroke"]),
        "planar-cables" => (&[], &[]),
        _ => (&["length"], &["length_offset", "stroke", "nominal"]),
    }
}

/// Refuses legs that lack a key of their kind or have one that means nothing for it.
pub(crate) fn check_keys(r: &Reader<'_>, kind: &str, legs: &[LegEntry]) -> Result<(), FileError> {
    let (needed, optional) = keys(kind);
    for (i, leg) in legs.iter().enumerate() {
        let nominal = leg.nominal_platform.is_some() || leg.nominal_base.is_some() || leg.nominal_length_offset != 0.0;
        let stated = [
            ("length", leg.length.is_some()),
            ("crank", leg.crank.is_some()),
            ("axis", leg.axis.is_some()),
            ("zero", leg.zero.is_some()),
            ("carriage", leg.carriage.is_some()),
            ("rail", leg.rail.is_some()),
            ("length_offset", leg.length_offset != 0.0),
            ("angle_offset", leg.angle_offset != 0.0),
            ("hinge_tilt", leg.hinge_tilt != [0.0; 2]),
            ("stroke", leg.stroke.is_some()),
            ("nominal", nominal),
        ];
        for (key, stated) in stated {
            let place = || format!("leg {}, `{key}`", i + 1);
            if needed.contains(&key) && !stated {
                return Err(r.value(place(), format!("is missing; a leg of type \"{kind}\" needs it")));
            }
            if stated && !needed.contains(&key) && !optional.contains(&key) {
                return Err(r.value(place(), format!("does not apply to type \"{kind}\"; delete it")));
            }
        }
    }
    Ok(())
}

/// The tolerances of a document, SI.
fn tolerances(r: &Reader<'_>, document: &MechanismDocument) -> Result<Option<Tolerances>, FileError> {
    let Some(t) = &document.tolerance else { return Ok(None) };
    let (anchor, length) = r.tolerance(t)?;
    let angle = t.angle.map(|v| r.known("[tolerance] angle", v)).transpose()?;
    let radii = |point: fn(&LegEntry) -> &[f64; 3]| {
        let n = document.legs.len().max(1) as f64;
        document.legs.iter().map(|l| r.length.to_si(Vector3::from_column_slice(point(l)).norm())).sum::<f64>() / n
    };
    let radius = Some(radii(|l| &l.platform)).filter(|v| *v > 0.0).unwrap_or_else(|| radii(|l| &l.base));
    Ok(Some(Tolerances {
        anchor,
        length,
        angle: angle.map_or(anchor / radius.max(f64::MIN_POSITIVE), |v| r.angle.to_si(v)),
    }))
}

/// The mechanism of a document that is not one of six hardpoints, from these legs and cables, in the frames of its
/// drawing.
pub(crate) fn read(
    r: &Reader<'_>,
    document: &MechanismDocument,
    legs: &[LegEntry],
    cables: &[CableEntry],
    home: Pose,
) -> Result<Box<dyn Mechanism>, FileError> {
    check_keys(r, &document.kind, legs)?;
    if document.kind != "planar-cables" && !cables.is_empty() {
        return Err(r.value("[[cable]]", format!("does not apply to type \"{}\"; delete it", document.kind)));
    }
    let tolerances = tolerances(r, document)?;
    let name = &document.name;
    let made = |result| finished(r, document, result);
    match document.kind.as_str() {
        "rotary-stewart" => {
            let legs = each(r, legs, |at, l| {
                Ok(CrankLeg {
                    platform: at.point("platform", &l.platform)?,
                    base: at.point("base", &l.base)?,
                    rod: at.positive("length", l.length)?,
                    crank: at.positive("crank", l.crank)?,
                    axis: at.direction("axis", l.axis)?,
                    zero: at.direction("zero", l.zero)?,
                    offset: r.angle.to_si(at.finite("angle_offset", l.angle_offset)?),
                    stroke: at.stroke(l.stroke, Dimension::Angle)?,
                })
            })?;
            made(RotaryStewart::new(name, &legs, home, tolerances).map(boxed))
        }
        "linear-delta" => {
            let rods = each(r, legs, |at, l| {
                let carriage = l.carriage.unwrap_or(0);
                if !(1..=3).contains(&carriage) {
                    return Err(r.value(at.place("carriage"), format!("{carriage} is not 1, 2 or 3")));
                }
                Ok(Rod {
                    platform: at.point("platform", &l.platform)?,
                    base: at.point("base", &l.base)?,
                    length: at.positive("length", l.length)?,
                    carriage: carriage - 1,
                    rail: at.direction("rail", l.rail)?,
                    stroke: at.stroke(l.stroke, Dimension::Length)?,
                })
            })?;
            made(LinearDelta::new(name, &rods, home, tolerances).map(boxed))
        }
        "tripod-3rps" => {
            let hinged = each(r, legs, |at, l| {
                let tilt = [at.finite("hinge_tilt", l.hinge_tilt[0])?, at.finite("hinge_tilt", l.hinge_tilt[1])?];
                Ok(HingedLeg {
                    platform: at.point("platform", &l.platform)?,
                    base: at.point("base", &l.base)?,
                    axis: at.direction("axis", l.axis)?,
                    tilt: tilt.map(|v| r.angle.to_si(v)),
                    offset: r.length.to_si(at.finite("length_offset", l.length_offset)?),
                    stroke: at.stroke(l.stroke, Dimension::Length)?,
                })
            })?;
            made(Tripod::new(name, &hinged, home, tolerances).map(boxed))
        }
        _ => {
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
                            format!("{k} is not a leg; legs are numbered from 1 to {}", legs.len()),
                        )
                    };
                    k.checked_sub(1).filter(|k| *k < legs.len()).ok_or_else(problem)
                };
                let dimension = if c.drum.is_some() { Dimension::Angle } else { Dimension::Length };
                read.push(Cable {
                    segments: c.segments.iter().map(segment).collect::<Result<_, _>>()?,
                    drum: c.drum.map(|v| at.positive("drum", Some(v))).transpose()?,
                    offset: r.length.to_si(at.finite("length_offset", c.length_offset)?),
                    stroke: at.stroke(c.stroke, dimension)?,
                });
            }
            made(PlanarCables::new(name, &segments, &read, home, tolerances).map(boxed))
        }
    }
}

/// What the four kinds have in common once they are made.
trait Kind: Mechanism {
    fn narrowed(&self, keep: &dyn Fn(&ParameterSpec) -> bool) -> Result<Box<dyn Mechanism>, GeometryError>;
    fn stems(&self) -> Vec<String>;
}

impl<C: Closure> Kind for ClosureMechanism<C> {
    fn narrowed(&self, keep: &dyn Fn(&ParameterSpec) -> bool) -> Result<Box<dyn Mechanism>, GeometryError> {
        Ok(Box::new(self.identifying(keep)?))
    }

    fn stems(&self) -> Vec<String> {
        let mut stems: Vec<String> = self.outline().parameters.iter().map(|p| stem(&p.name).to_owned()).collect();
        stems.sort();
        stems.dedup();
        stems
    }
}

fn boxed<C: Closure>(made: ClosureMechanism<C>) -> Box<dyn Kind> {
    Box::new(made)
}

/// The name of a parameter without the number of its leg.
fn stem(name: &str) -> &str {
    name.trim_end_matches(|c: char| c.is_ascii_digit())
}

/// The mechanism in the frames of the measurement, if the file states them.
pub(crate) fn mounted(
    r: &Reader<'_>,
    document: &MechanismDocument,
    drawn: Box<dyn Mechanism>,
) -> Result<Box<dyn Mechanism>, FileError> {
    let Some(m) = &document.mounting else { return Ok(drawn) };
    let pose = |place: &str, p: &[f64; 3], a: &[f64; 3]| Ok(Pose::from_coordinates(&r.six(place, p, a)?));
    let base = pose("[mounting] base", &m.base_position, &m.base_rotation)?;
    let target = pose("[mounting] target", &m.target_position, &m.target_rotation)?;
    Ok(drawn.mounted(&base, &target).unwrap_or(drawn))
}

/// The parameters that `identify` asks for.
fn finished(
    r: &Reader<'_>,
    document: &MechanismDocument,
    made: Result<Box<dyn Kind>, GeometryError>,
) -> Result<Box<dyn Mechanism>, FileError> {
    let geometry = |cause| FileError::Geometry { path: r.path.into(), cause };
    let made = made.map_err(geometry)?;
    let stems = made.stems();
    if let Some(unknown) = document.identify.iter().flatten().find(|s| !stems.contains(s)) {
        let problem = format!("'{unknown}' is not a parameter; those of this kind are {}", stems.join(", "));
        return Err(r.value("identify", problem));
    }
    let wanted =
        |spec: &ParameterSpec| document.identify.as_ref().is_none_or(|w| w.iter().any(|s| s == stem(&spec.name)));
    let nothing = document.identify.as_ref().is_some_and(Vec::is_empty);
    if nothing {
        return Err(r.value("identify", "names no parameter; name some, or delete it to identify all"));
    }
    made.narrowed(&wanted).map_err(geometry)
}

/// One entry of a list of a file.
struct Row<'a> {
    r: &'a Reader<'a>,
    section: &'static str,
    row: usize,
}

/// Reads every leg.
fn each<T>(
    r: &Reader<'_>,
    legs: &[LegEntry],
    read: impl Fn(&Row<'_>, &LegEntry) -> Result<T, FileError>,
) -> Result<Vec<T>, FileError> {
    legs.iter().enumerate().map(|(i, l)| read(&Row { r, section: "leg", row: i + 1 }, l)).collect()
}

impl Row<'_> {
    fn place(&self, key: &str) -> String {
        format!("{} {}, `{key}`", self.section, self.row)
    }

    fn finite(&self, key: &str, v: f64) -> Result<f64, FileError> {
        self.r.finite(&self.place(key), v)
    }

    fn point(&self, key: &str, p: &[f64; 3]) -> Result<Vector3<f64>, FileError> {
        self.r.point(&self.place(key), p)
    }

    /// A length that must be stated.
    fn positive(&self, key: &str, v: Option<f64>) -> Result<f64, FileError> {
        Ok(self.r.length.to_si(self.r.positive(&self.place(key), v.unwrap_or(f64::NAN))?))
    }

    /// A direction that must be stated; it has no unit.
    fn direction(&self, key: &str, v: Option<[f64; 3]>) -> Result<Vector3<f64>, FileError> {
        let v = v.unwrap_or([0.0; 3]);
        v.iter().try_for_each(|x| self.finite(key, *x).map(drop))?;
        if v == [0.0; 3] {
            return Err(self.r.value(self.place(key), "[0, 0, 0] is not a direction; write a vector of any length"));
        }
        Ok(v.into())
    }

    fn stroke(&self, stroke: Option<[f64; 2]>, dimension: Dimension) -> Result<Option<[f64; 2]>, FileError> {
        let Some([from, to]) = stroke else { return Ok(None) };
        if !(from < to && from.is_finite() && to.is_finite()) {
            return Err(self
                .r
                .value(self.place("stroke"), format!("[{from}, {to}] is not an interval; write [from, to]")));
        }
        let unit = if dimension == Dimension::Angle { self.r.angle } else { self.r.length };
        Ok(Some([unit.to_si(from), unit.to_si(to)]))
    }
}

/// All parameters of a mechanism of one of these kinds with their values, its home and its mounting.
pub(crate) struct Parts {
    pub(crate) values: Vec<(ParameterSpec, f64)>,
    pub(crate) home: Pose,
    pub(crate) mounting: Option<(Pose, Pose)>,
}

/// The parts of a mechanism if it is of one of these kinds.
pub(crate) fn parts(mechanism: &dyn Mechanism) -> Option<Parts> {
    fn of<C: Closure>(mechanism: &dyn Any) -> Option<Parts> {
        let m = mechanism.downcast_ref::<ClosureMechanism<C>>()?;
        let values = m.outline().parameters.iter().cloned().zip(m.all_values().iter().copied()).collect();
        Some(Parts { values, home: m.own_home(), mounting: m.mounting() })
    }
    let any: &dyn Any = mechanism;
    of::<RotaryStewart>(any)
        .or_else(|| of::<LinearDelta>(any))
        .or_else(|| of::<Tripod>(any))
        .or_else(|| of::<PlanarCables>(any))
}

/// Puts values into the entries of a file, in its units.
pub(crate) fn write(values: &[(ParameterSpec, f64)], r: &Reader<'_>, legs: &mut [LegEntry], cables: &mut [CableEntry]) {
    for (spec, value) in values {
        let v = match spec.dimension {
            Dimension::Angle => r.angle.from_si(*value),
            Dimension::Length => r.length.from_si(*value),
            _ => *value,
        };
        let stem = stem(&spec.name);
        let leg_of = |leg: usize, legs: &mut [LegEntry], put: &dyn Fn(&mut LegEntry)| legs.get_mut(leg).map(put);
        // Which key a parameter has in the file is a matter of its kind, told apart by role and stem.
        let _ = match spec.role {
            ParameterRole::PlatformPoint { leg, axis } => leg_of(leg, legs, &|l| l.platform[axis.index()] = v),
            ParameterRole::BasePoint { leg, axis } => leg_of(leg, legs, &|l| l.base[axis.index()] = v),
            ParameterRole::JointScale { leg } => cables.get_mut(leg).map(|c| c.drum = Some(v)),
            ParameterRole::JointOffset { leg } if !cables.is_empty() => {
                cables.get_mut(leg).map(|c| c.length_offset = v)
            }
            ParameterRole::JointOffset { leg } if spec.dimension == Dimension::Angle => {
                leg_of(leg, legs, &|l| l.angle_offset = v)
            }
            ParameterRole::JointOffset { leg } => leg_of(leg, legs, &|l| l.length_offset = v),
            ParameterRole::LegDimension { leg } => leg_of(leg, legs, &|l| match stem {
                "r" => l.crank = Some(v),
                "m" => l.hinge_tilt[0] = v,
                "n" => l.hinge_tilt[1] = v,
                _ => l.length = Some(v),
            }),
            ParameterRole::PoseOffset { .. } | ParameterRole::Other => None,
        };
    }
}
