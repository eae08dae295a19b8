//! Surroundings of the mechanism as its file states them, SI.

use std::collections::BTreeMap;

use crate::conditions::ConditionTable;
use crate::effect::{Environment, Sensor};
use crate::files::error::FileError;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::reader::Reader;
use crate::files::mechanism::sections::SensorEntry;
use crate::mechanism::Body;
use crate::pose::PoseConvention;
use crate::units::{Dimension, Unit};

/// The environment of a document, without the reference temperatures of its effects and without the joints at home.
pub(crate) fn environment(
    r: &Reader<'_>,
    document: &MechanismDocument,
    kinds: &ConditionTable,
    convention: PoseConvention,
) -> Result<Environment, FileError> {
    let reference = document.reference_temperature;
    let platform = document.platform.as_ref();
    let point = |place: &str, p: Option<[f64; 3]>| p.map(|v| r.point(place, &v)).transpose();
    let mass = platform.and_then(|p| p.mass_kg);
    let pitch = document.actuator.as_ref().and_then(|a| a.screw_pitch);
    let mut sensors: Vec<Sensor> = Vec::with_capacity(document.sensors.len());
    for (k, entry) in document.sensors.iter().enumerate() {
        let sensor = sensor(r, k, entry, kinds)?;
        if let Some(other) = sensors.iter().position(|s| s.covariate == sensor.covariate) {
            let problem = format!("'{}' is already that of sensor {}; name another", entry.covariate, other + 1);
            return Err(r.value(format!("sensor {}, `covariate`", k + 1), problem));
        }
        sensors.push(sensor);
    }
    Ok(Environment {
        condition_kinds: kinds.clone(),
        convention,
        reference_temperature: reference.map(|v| r.finite("reference_temperature_degC", v)).transpose()?,
        references: BTreeMap::new(),
        mass: mass.map(|v| r.known("[platform] mass_kg", v)).transpose()?,
        centre_of_mass: point("[platform] centre_of_mass", platform.and_then(|p| p.centre_of_mass))?,
        payload_centre: point("[platform] payload_centre", platform.and_then(|p| p.payload_centre))?,
        screw_pitch: pitch.map(|v| Ok(r.units.length.to_si(r.known("[actuator] screw_pitch", v)?))).transpose()?,
        sensors,
        home_joints: None,
        home: None,
        home_legs: None,
    })
}

fn sensor(r: &Reader<'_>, k: usize, entry: &SensorEntry, kinds: &ConditionTable) -> Result<Sensor, FileError> {
    let place = |key: &str| format!("sensor {}, `{key}`", k + 1);
    let name = &entry.covariate;
    let with_unit = name
        .rsplit_once('_')
        .is_some_and(|(_, unit)| Unit::named(unit).is_some_and(|u| u.dimension == Dimension::Temperature));
    if !kinds.is_temperature(name) || with_unit {
        let problem =
            "is not the name of a temperature; write that of the data column without its unit, such as \"temp_base1\"";
        return Err(r.value(place("covariate"), format!("'{name}' {problem}")));
    }
    let (body, key, at) = match (entry.platform, entry.base) {
        (Some(at), None) => (Body::Platform, "platform", at),
        (None, Some(at)) => (Body::Base, "base", at),
        (None, None) => return Err(r.value(place("base"), "or `platform` is missing; state where the sensor sits")),
        (Some(_), Some(_)) => return Err(r.value(place("base"), "and `platform` are both stated; keep one of them")),
    };
    Ok(Sensor { covariate: name.clone(), body, place: r.point(&place(key), &at)? })
}
