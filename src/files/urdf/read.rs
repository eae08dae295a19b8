//! From the text of a URDF file, and what stands beside it, to a [`Machine`].

use std::path::Path;

use nalgebra::Vector3;

use super::beside::{Beside, add_home};
use super::description::Description;
use super::extract::extract;
use super::findings::Findings;
use super::found::{Found, FoundLeg};
use super::side::{PerLeg, SideDocument, parse};
use super::xml;
use crate::conditions::Conditions;
use crate::files::error::{FileError, read_text};
use crate::files::finding::{Finding, FindingKind};
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::read::build;
use crate::files::mechanism::reader::Reader;
use crate::files::mechanism::sections::LegEntry;
use crate::files::read_options::ReadOptions;
use crate::mechanism::condition;
use crate::pose::{Pose, PoseConvention};

/// Reads a URDF file and what stands beside it.
pub(in crate::files) fn read(path: &Path, text: &str, options: &ReadOptions) -> Result<Machine, FileError> {
    machine(path, text, options, Beside::find(path, None)?)
}

/// Reads the text of a URDF file alone.
pub(in crate::files) fn from_text(path: &Path, text: &str, options: &ReadOptions) -> Result<Machine, FileError> {
    machine(path, text, options, Beside::default())
}

/// Reads a TOML file that names a URDF.
pub(in crate::files) fn read_named(
    toml: &Path,
    text: &str,
    urdf: &str,
    options: &ReadOptions,
) -> Result<Machine, FileError> {
    let document: SideDocument = parse(text, toml)?;
    let path = toml.parent().unwrap_or(Path::new("")).join(urdf);
    let robot = read_text(&path)?;
    let mut machine = machine(&path, &robot, options, Beside::find(&path, Some((toml.into(), document)))?)?;
    machine.path = toml.into();
    Ok(machine)
}

fn machine(path: &Path, text: &str, options: &ReadOptions, beside: Beside) -> Result<Machine, FileError> {
    let refused = |findings: Vec<Finding>| FileError::Urdf { path: path.into(), findings };
    let mut settings = beside.settings(&options.urdf)?;
    let home_joints = beside.home_joints();
    let Beside { toml, mut files, warnings, .. } = beside;
    let (side_path, document) = toml.unzip();
    let place = side_path.clone().unwrap_or_else(|| path.into());
    let per_leg = document.as_ref().map(|d| d.per_leg(&place)).transpose()?.unwrap_or_default();

    let root = xml::parse(text).map_err(|finding| refused(vec![finding]))?;
    let mut findings = Findings::default();
    let description = Description::of(&root, &mut findings);
    findings.stop_on_errors().map_err(refused)?;

    let mut document = document.unwrap_or_default().into_document(&description.name);
    let reader = Reader::of(&place, &document)?;
    add_home(&mut settings, home_joints, |joint, v| {
        let slide = description.joints.iter().any(|j| j.name == joint && j.kind == "prismatic");
        if slide { reader.units.length.to_si(v) } else { reader.units.angle.to_si(v) }
    });
    let found = extract(&description, &settings, &mut findings);
    findings.stop_on_errors().map_err(refused)?;
    let Some(found) = found else {
        let text =
            "no mechanism was found in it, for an unknown reason; compare it with a file that can be read".into();
        return Err(refused(vec![Finding {
            kind: FindingKind::NoLoopClosures,
            element: String::new(),
            line: None,
            text,
        }]));
    };
    let convention = PoseConvention {
        order: document.rotation_order,
        pivot: Vector3::from(document.pivot).map(|v| reader.units.length.to_si(v)),
    };
    fill(&mut document, &found, per_leg, &reader, &convention);
    let mut machine = build(&reader, document, options).map_err(|error| match error {
        FileError::Geometry { cause, .. } => FileError::Geometry { path: path.into(), cause },
        error => error,
    })?;
    files.push(path.into());
    machine.path = path.into();
    machine.inputs = files;
    let mut all = warnings;
    all.extend(findings.into_warnings().iter().map(|f| format!("{}: {f}", path.display())));
    all.extend(loose_home(&machine, path));
    all.append(&mut machine.warnings);
    machine.warnings = all;
    Ok(machine)
}

/// Writes legs and home into a document, in its units.
fn fill(
    document: &mut MechanismDocument,
    found: &Found,
    per_leg: PerLeg,
    reader: &Reader<'_>,
    convention: &PoseConvention,
) {
    let length = |v: f64| reader.units.length.from_si(v);
    let leg = |(k, l): (usize, &FoundLeg)| {
        // URDF knows the true length; the commanded one is shorter by the offset.
        let offset = per_leg.offsets.map_or(0.0, |o| o[k]);
        let range = l.range.map(|r| r.map(|v| length(v) - offset));
        LegEntry {
            platform: reader.units.point(&l.platform),
            base: reader.units.point(&l.base),
            length: Some(length(l.length) - offset),
            length_offset: offset,
            stroke: per_leg.strokes.map_or(range, |s| s[k]),
            joint: Some(l.joint.clone()),
            joint_reversed: l.reversed,
            ..LegEntry::default()
        }
    };
    document.legs = found.legs.iter().enumerate().map(leg).collect();
    let section = |home: &Pose| reader.units.home(convention, home);
    document.home = document.home.take().or_else(|| found.home.as_ref().map(section));
}

/// A home that is held, but badly.
fn loose_home(machine: &Machine, path: &Path) -> Option<String> {
    const LOOSE: f64 = 1e4;
    let (mechanism, at) = (machine.mechanism.as_ref(), Conditions::unknown());
    let joints = mechanism.inverse(mechanism.values(), &mechanism.home(), &at).ok()?;
    let condition = condition(mechanism, mechanism.values(), &joints, &mechanism.home(), &at);
    (condition > LOOSE).then(|| {
        let kind = FindingKind::SingularHome;
        let text = "the legs hardly hold the platform at home; check anchors and home pose";
        format!("{}: {kind}: condition {condition:.1e}: {text}", path.display())
    })
}
