//! `type = "own"`: a mechanism that a program defines. The file holds the values of its parameters; the rest comes from
//! the program that reads it ([`ReadOptions::mechanism`](crate::files::ReadOptions::mechanism)).

use super::file_kind::{FileKind, Made, Source, Target};
use crate::files::error::FileError;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::reader::Reader;
use crate::files::mechanism::sections::ParameterEntry;
use crate::measurement::Frames;
use crate::mechanism::{Mechanism, ParameterSpec};

/// A mechanism that a program defines.
pub(crate) const KIND: FileKind = FileKind {
    name: "own",
    label: "a mechanism that a program defines",
    needed: &[],
    optional: &[],
    parts: &["[[parameter]]", "[mounting]"],
    points_move: true,
    example: None,
    read,
    write,
};

fn read(source: &Source<'_>, _warned: &mut Vec<String>) -> Result<Made, FileError> {
    let Source { reader: r, document, convention, home, own } = *source;
    let Some(own) = own else {
        let problem = "\"own\" is a mechanism that a program defines; read the file with that program";
        return Err(r.value("type", problem));
    };
    let geometry = |cause| r.geometry(cause);
    let nominal = own.with_values(own.values(), own.home()).map_err(geometry)?;
    if document.parameters.is_empty() {
        return Ok((nominal, None));
    }
    let home = home.map_or_else(|| own.home(), |q| convention.pose(&q));
    let drawn = own.with_values(&values(r, own.parameters(), &document.parameters)?, home).map_err(geometry)?;
    Ok((drawn, Some(nominal)))
}

/// The value of each parameter, SI.
fn values(r: &Reader<'_>, specs: &[ParameterSpec], entries: &[ParameterEntry]) -> Result<Vec<f64>, FileError> {
    for (k, entry) in entries.iter().enumerate() {
        let place = format!("[[parameter]] '{}'", entry.name);
        if !specs.iter().any(|spec| spec.name == entry.name) {
            let names: Vec<&str> = specs.iter().map(|spec| spec.name.as_str()).collect();
            return Err(r.value(place, format!("is not a parameter; the mechanism has {}", names.join(", "))));
        }
        if entries[..k].iter().any(|other| other.name == entry.name) {
            return Err(r.value(place, "is stated twice; keep one value"));
        }
    }
    let value = |spec: &ParameterSpec| {
        let place = format!("[[parameter]] '{}'", spec.name);
        let Some(entry) = entries.iter().find(|entry| entry.name == spec.name) else {
            return Err(r.value(place, "is missing; state its value, or delete all of them for the nominal mechanism"));
        };
        Ok(r.units.of(spec.dimension).to_si(r.finite(&place, entry.value)?))
    };
    specs.iter().map(value).collect()
}

fn write(mechanism: &dyn Mechanism, target: &Target, document: &mut MechanismDocument) -> bool {
    let entry = |(spec, value): (&ParameterSpec, &f64)| ParameterEntry {
        name: spec.name.clone(),
        value: target.units.of(spec.dimension).from_si(*value),
    };
    document.parameters = mechanism.parameters().iter().zip(mechanism.values()).map(entry).collect();
    let mounting = mechanism.mounting();
    let home = match mounting {
        Some((base, target)) => Frames { base, target }.platform(&mechanism.home()),
        None => mechanism.home(),
    };
    document.home = Some(target.units.home(&target.convention, &home));
    true
}
