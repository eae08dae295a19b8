//! URDF files of mechanisms with six legs of variable length.
//!
//! URDF describes a tree of links and joints; a parallel mechanism has loops. Each tool states the missing closures in
//! its own way, so a file goes through these steps:
//!
//! 1. [`xml`] reads the text within bounds, [`description`] keeps what matters and checks every number, and
//!    `urdf-rs` reads the reduced rest: its joints and links are those of [`model`].
//! 2. [`closures`] collects the tags that close loops, [`pairs`] the closing frames and the pairs of [`side`] files
//!    and of the call; [`agree`] sorts out what is stated twice.
//! 3. [`graph`] finds base, platform and legs by their connections, [`leg`] and [`anchor`] the anchors `a`, `b` and the length
//!    `L0` at joint coordinate zero: with `c` the common point of the axes at the platform's end,
//!    `L0 = |c - b|` and `length = L0 ± q`. Names decide only which
//!    link carries the frame of its body. The zero pose need not be assembled, but for closures that state their place in
//!    one link only (`<gazebo><joint>`).
//! 4. [`extract`] puts it together, with the pose at [`home`]: that of the tree if it closes every loop, else the nearest
//!    that fits the lengths.
//!
//! The result is the same document that a TOML file holds, so all else is common to both. Everything that is wrong
//! is collected as [`Finding`]s. [`writer`] goes the other way.

mod agree;
mod anchor;
mod choice;
mod closures;
mod description;
mod extract;
mod finding;
mod graph;
mod home;
mod leg;
mod model;
mod options;
mod output;
mod pairs;
mod side;
mod writer;
mod xml;

pub use finding::{Finding, FindingKind};
pub use options::{HomeJoint, UrdfOptions};
pub use output::WrittenMechanism;
pub use writer::UrdfFiles;

pub(super) use finding::findings_text;
pub(super) use output::is_urdf;
pub(super) use side::names_a_urdf;

use std::path::Path;

use nalgebra::Vector3;

use self::description::Description;
use self::extract::{Found, FoundLeg, extract};
use self::finding::Findings;
use self::side::{Beside, PerLeg, SideDocument, add_home};
use crate::files::error::{FileError, read_text};
use crate::files::machine::Machine;
use crate::files::mechanism::document::{HomeSection, LegEntry, MechanismDocument};
use crate::files::mechanism::read::{Reader, build};
use crate::pose::{Pose, PoseConvention};

/// True if a text is XML.
pub(super) fn is_xml(text: &str) -> bool {
    text.trim_start().starts_with('<')
}

/// Reads a URDF file and what stands beside it.
pub(super) fn read(path: &Path, text: &str, options: &UrdfOptions) -> Result<Machine, FileError> {
    machine(path, text, options, Beside::find(path, None)?)
}

/// Reads the text of a URDF file alone.
pub(super) fn from_text(path: &Path, text: &str, options: &UrdfOptions) -> Result<Machine, FileError> {
    machine(path, text, options, Beside::default())
}

/// Reads a TOML file that names a URDF.
pub(super) fn read_named(toml: &Path, text: &str, urdf: &str, options: &UrdfOptions) -> Result<Machine, FileError> {
    let document: SideDocument = side::parse(text, toml)?;
    let path = toml.parent().unwrap_or(Path::new("")).join(urdf);
    let robot = read_text(&path)?;
    let mut machine = machine(&path, &robot, options, Beside::find(&path, Some((toml.into(), document)))?)?;
    machine.path = toml.into();
    Ok(machine)
}

fn machine(path: &Path, text: &str, options: &UrdfOptions, beside: Beside) -> Result<Machine, FileError> {
    let refused = |findings: Vec<Finding>| FileError::Urdf { path: path.into(), findings };
    let mut settings = beside.settings(options)?;
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
        if slide { reader.length.to_si(v) } else { reader.angle.to_si(v) }
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
        pivot: Vector3::from(document.pivot).map(|v| reader.length.to_si(v)),
    };
    fill(&mut document, &found, per_leg, &reader, &convention);
    let mut machine = build(&reader, document).map_err(|error| match error {
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
    let length = |v: f64| reader.length.from_si(v);
    let point = |p: &Vector3<f64>| [length(p.x), length(p.y), length(p.z)];
    let leg = |(k, l): (usize, &FoundLeg)| {
        // URDF knows the true length; the commanded one is shorter by the offset.
        let offset = per_leg.offsets.map_or(0.0, |o| o[k]);
        let range = l.range.map(|r| r.map(|v| length(v) - offset));
        LegEntry {
            platform: point(&l.platform),
            base: point(&l.base),
            length: Some(length(l.length) - offset),
            length_offset: offset,
            stroke: per_leg.strokes.map_or(range, |s| s[k]),
            joint: Some(l.joint.clone()),
            joint_reversed: l.reversed,
            ..LegEntry::default()
        }
    };
    document.legs = found.legs.iter().enumerate().map(leg).collect();
    let section = |home: &Pose| {
        let q = convention.coordinates(home);
        let angle = |v: f64| reader.angle.from_si(v);
        HomeSection { position: [q[0], q[1], q[2]].map(length), rotation: [q[3], q[4], q[5]].map(angle) }
    };
    document.home = document.home.take().or_else(|| found.home.as_ref().map(section));
}

/// A home that is held, but badly.
fn loose_home(machine: &Machine, path: &Path) -> Option<String> {
    const LOOSE: f64 = 1e4;
    let (mechanism, at) = (machine.mechanism.as_ref(), crate::conditions::Conditions::unknown());
    let joints = mechanism.inverse(mechanism.values(), &mechanism.home(), &at).ok()?;
    let condition = crate::mechanism::condition(mechanism, mechanism.values(), &joints, &mechanism.home(), &at);
    (condition > LOOSE).then(|| {
        let kind = FindingKind::SingularHome;
        let text = "the legs hardly hold the platform at home; check anchors and home pose";
        format!("{}: {kind}: condition {condition:.1e}: {text}", path.display())
    })
}
