//! From the words of a mechanism file to a [`Machine`]: units, ranges, and what does not fit together.

use crate::conditions::Conditions;
use crate::effect::{Environment, leg_directions, without_effects};
use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::effects::{Effects, with_effects};
use crate::files::mechanism::environment::environment;
use crate::files::mechanism::joint_names::check_joints;
use crate::files::mechanism::kinds::file_kind::{FileKind, Source};
use crate::files::mechanism::kinds::{self, KINDS, six_hardpoint};
use crate::files::mechanism::reader::Reader;
use crate::files::read_options::ReadOptions;
use crate::measurement::{Noise, TargetPoint};
use crate::mechanism::{Mechanism, Workspace, mirrored_home, mount};
use crate::pose::{Pose, PoseConvention};
use crate::units::Dimension;

/// Builds the machine of a document.
pub(crate) fn build(
    reader: &Reader<'_>,
    document: MechanismDocument,
    options: &ReadOptions,
) -> Result<Machine, FileError> {
    let kind = kind_of(reader, &document)?;
    let pivot = reader.point("pivot", &document.pivot)?;
    let convention = PoseConvention { order: document.rotation_order, pivot };
    let home = document.home.as_ref().map(|h| reader.six("[home]", &h.position, &h.rotation)).transpose()?;
    kind.check_parts(reader, &document)?;
    let mut warnings = Vec::new();
    let own = options.mechanism.as_deref();
    let source = Source { reader, document: &document, convention: &convention, home, own };
    let (mechanism, nominal) = (kind.read)(&source, &mut warnings)?;
    // Other kinds state their home.
    let solved = home.is_none() && document.kind == six_hardpoint::KIND.name;
    let other_home = if solved { mirrored_home(mechanism.as_ref()) } else { None };
    let noise = noise(reader, &document, mechanism.as_ref())?;
    let targets = targets(reader, &document)?;
    let contact = document.plane.as_ref().map(|p| p.read(reader)).transpose()?.unwrap_or_default();
    let commander = nominal.as_deref().unwrap_or(mechanism.as_ref());
    let home_joints = commander.inverse(commander.values(), &commander.home(), &Conditions::unknown()).ok();
    let home_legs = Some(leg_directions(commander, commander.values(), &commander.home()));
    let environment = Environment {
        home: Some(commander.home()),
        home_joints,
        home_legs,
        ..environment(reader, &document, &options.condition_kinds, convention)?
    };
    let Effects { mechanism, instrument, environment } =
        with_effects(reader, &document, mechanism, environment, &options.catalogue)?;
    let mounting = document.mounting.as_ref().map(|m| m.read(reader)).transpose()?;
    let plain = mounted_without_effects(reader, mechanism.as_ref(), mounting)?;
    let mechanism = match mounting {
        Some([base, target]) => mount(mechanism, &base, &target),
        None => mechanism,
    };
    let workspace = workspace(
        &Source { reader, document: &document, convention: &convention, home, own },
        mechanism.as_ref(),
        &mut warnings,
    )?;
    warnings.extend(check_joints(reader, &document, &options.condition_kinds)?);
    Ok(Machine {
        path: reader.path.into(),
        mechanism,
        plain,
        nominal,
        convention,
        workspace,
        noise,
        targets,
        contact,
        environment,
        catalogue: options.catalogue.clone(),
        own: options.mechanism.clone(),
        instrument,
        length_unit: reader.units.length,
        angle_unit: reader.units.angle,
        warnings,
        other_home,
        inputs: vec![reader.path.into()],
        document,
    })
}

/// A mechanism in the frames of a measurement and without its effects; `None` where that is the one with them.
fn mounted_without_effects(
    r: &Reader<'_>,
    mechanism: &dyn Mechanism,
    mounting: Option<[Pose; 2]>,
) -> Result<Option<Box<dyn Mechanism>>, FileError> {
    let Some([base, target]) = mounting.filter(|_| mechanism.extension().is_some()) else { return Ok(None) };
    let plain = without_effects(mechanism);
    let plain = plain.with_values(plain.values(), plain.home()).map_err(|cause| r.geometry(cause))?;
    Ok(Some(mount(plain, &base, &target)))
}

/// The kind that a document states.
fn kind_of(r: &Reader<'_>, document: &MechanismDocument) -> Result<&'static FileKind, FileError> {
    kinds::kind(&document.kind).ok_or_else(|| {
        let known: Vec<String> = KINDS.iter().map(|k| format!("\"{}\" ({})", k.name, k.label)).collect();
        r.value("type", format!("'{}' is not a kind of mechanism; use one of {}", document.kind, known.join(", ")))
    })
}

/// The stated workspace; coordinates that the joints do not control are taken out.
fn workspace(
    source: &Source<'_>,
    mechanism: &dyn Mechanism,
    warned: &mut Vec<String>,
) -> Result<Option<Workspace>, FileError> {
    let Source { reader: r, document, convention, .. } = *source;
    let Some(stated) = &document.workspace else { return Ok(None) };
    for v in stated.position.iter().chain(&stated.rotation) {
        r.not_negative("[workspace]", *v)?;
    }
    let mut half = r.six("[workspace]", &stated.position, &stated.rotation)?;
    // In the frames of a measurement the coordinates are mixed, and each may follow from the others.
    if document.mounting.is_none() {
        for (k, name) in ["x", "y", "z", "rx", "ry", "rz"].iter().enumerate() {
            if half[k] > 0.0 && !mechanism.controlled()[k] {
                half[k] = 0.0;
                warned.push(format!("[workspace]: the joints do not control {name}; write 0 there"));
            }
        }
    }
    Ok(Some(Workspace { convention: *convention, centre: convention.coordinates(&mechanism.home()), half }))
}

/// The stated noise. That of the joints is in their unit.
fn noise(r: &Reader<'_>, document: &MechanismDocument, mechanism: &dyn Mechanism) -> Result<Option<Noise>, FileError> {
    let Some(stated) = &document.noise else { return Ok(None) };
    let angles = mechanism.joints().first().is_some_and(|j| j.dimension == Dimension::Angle);
    let joints = if angles { r.units.angle } else { r.units.length };
    Ok(Some(Noise {
        position: r.units.length.to_si(r.known("[noise] position", stated.position)?),
        rotation: r.units.angle.to_si(r.known("[noise] rotation", stated.rotation)?),
        joint: joints.to_si(r.not_negative("[noise] joint", stated.joint)?),
        known: true,
    }))
}

fn targets(r: &Reader<'_>, document: &MechanismDocument) -> Result<Vec<TargetPoint>, FileError> {
    let mut targets: Vec<TargetPoint> = Vec::with_capacity(document.targets.len());
    for t in &document.targets {
        let place = format!("[[target]] '{}'", t.name);
        if targets.iter().any(|k| k.name == t.name) {
            return Err(r.value(place, "is stated twice; give each target its own name"));
        }
        let platform = t.platform.as_ref().map(|p| r.point(&place, p)).transpose()?;
        targets.push(TargetPoint { name: t.name.clone(), platform });
    }
    Ok(targets)
}
