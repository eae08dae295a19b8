//! A mechanism file, read: the mechanism and what else is known about it.

use std::any::Any;
use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use super::document::{HomeSection, LegEntry, MechanismDocument, TargetEntry, WorkspaceSection};
use super::error::{FileError, read_text};
use super::mechanism_reader::{Reader, build};
use super::urdf::{self, UrdfOptions};
use crate::measurement::{Frames, Noise, TargetPoint};
use crate::mechanism::{GeometryError, Leg, Mechanism, SixHardpoint, Workspace};
use crate::pose::{Pose, PoseConvention};
use crate::units::Unit;

/// The only kind of mechanism that files can state so far.
pub(super) const SIX_HARDPOINT: &str = "six-hardpoint";

/// A mechanism with its surroundings, SI.
#[derive(Debug)]
pub struct Machine {
    /// Where it came from.
    pub path: PathBuf,
    /// The mechanism.
    pub mechanism: Box<dyn Mechanism>,
    /// The geometry by which the controller turns commanded poses into lengths, if that is another: a calibrated
    /// file keeps the nominal points.
    pub(super) nominal: Option<Box<dyn Mechanism>>,
    /// How its file and its data write poses.
    pub convention: PoseConvention,
    /// The workspace, if it is stated.
    pub workspace: Option<Workspace>,
    /// The noise, if it is stated.
    pub noise: Option<Noise>,
    /// Measured points of the platform.
    pub targets: Vec<TargetPoint>,
    /// Unit of its lengths.
    pub length_unit: Unit,
    /// Unit of its angles.
    pub angle_unit: Unit,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// Every file that it was read from.
    pub(super) inputs: Vec<PathBuf>,
    pub(super) document: MechanismDocument,
}

impl Machine {
    /// Reads a mechanism file: TOML, or URDF with what stands beside it.
    ///
    /// # Errors
    /// [`FileError`] naming the place and what to do.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, FileError> {
        Self::read_with(path, &UrdfOptions::default())
    }

    /// The same, with what a URDF file leaves open.
    ///
    /// # Errors
    /// [`FileError`] naming the place and what to do; also if `options` are given for a file without URDF.
    pub fn read_with(path: impl AsRef<Path>, options: &UrdfOptions) -> Result<Self, FileError> {
        let path = path.as_ref();
        let text = read_text(path)?;
        let value = |place: &str, problem: String| FileError::Value { path: path.into(), place: place.into(), problem };
        if urdf::is_xml(&text) || urdf::is_urdf(path) {
            return urdf::read(path, &text, options);
        }
        if let Some(robot) = urdf::names_a_urdf(&text) {
            return urdf::read_named(path, &text, &robot, options);
        }
        if !options.is_empty() {
            let problem = "closures, links and joint coordinates are stated for URDF files only, and this is none";
            return Err(value("the call", format!("{problem}; leave the options out")));
        }
        let machine = Self::from_text(&text, path);
        let robot = path.with_extension("urdf");
        if matches!(
            &machine,
            Err(FileError::Geometry { cause: GeometryError::LegCount { found: 0 }, .. } | FileError::Toml { .. })
        ) && robot.is_file()
            && !text.contains("[[leg]]")
        {
            let problem = format!("there is none; this file belongs to '{}', name that one", robot.display());
            return Err(value("[[leg]]", problem));
        }
        machine
    }

    /// Reads the text of a mechanism file, TOML or URDF; `path` is only named in errors, and nothing beside it is read.
    ///
    /// # Errors
    /// [`FileError`] naming the place and what to do.
    pub fn from_text(text: &str, path: &Path) -> Result<Self, FileError> {
        if urdf::is_xml(text) {
            return urdf::from_text(path, text, &UrdfOptions::default());
        }
        let document: MechanismDocument = toml::from_str(text)
            .map_err(|e| FileError::Toml { path: path.into(), message: e.to_string().trim_end().to_owned() })?;
        Self::from_document(document, path)
    }

    /// The machine of a document; `path` is only named in errors.
    ///
    /// # Errors
    /// [`FileError`] naming the place and what to do.
    pub fn from_document(document: MechanismDocument, path: &Path) -> Result<Self, FileError> {
        build(&Reader::of(path, &document)?, document)
    }

    /// Every file that it was read from.
    pub fn inputs(&self) -> &[PathBuf] {
        &self.inputs
    }

    /// The file as it was read; a URDF as the TOML file that says the same.
    pub fn document(&self) -> &MechanismDocument {
        &self.document
    }

    /// The mechanism by which the controller turns commanded poses into joints.
    pub fn commander(&self) -> &dyn Mechanism {
        self.nominal.as_deref().unwrap_or(self.mechanism.as_ref())
    }

    /// The file for another state of the same mechanism: calibrated values, home and workspace in SI, and targets
    /// whose places were identified. `frames` are those that `mechanism` was carried into; what the file states on the
    /// platform goes along. Other sections are kept.
    ///
    /// # Errors
    /// [`FileError::Value`] for a mechanism of another kind.
    pub fn document_of(
        &self,
        mechanism: &dyn Mechanism,
        workspace: Option<&Workspace>,
        targets: &[TargetPoint],
        frames: &Frames,
    ) -> Result<MechanismDocument, FileError> {
        let Some(legs) = (mechanism as &dyn Any).downcast_ref::<SixHardpoint>().map(SixHardpoint::to_legs) else {
            return Err(FileError::Value {
                path: self.path.clone(),
                place: "type".into(),
                problem: format!("a mechanism of another kind than '{SIX_HARDPOINT}' cannot be written"),
            });
        };
        let length = |v: f64| self.length_unit.from_si(v);
        let angle = |v: f64| self.angle_unit.from_si(v);
        let point = |p: &Vector3<f64>| [length(p.x), length(p.y), length(p.z)];
        let entry = |l: &Leg| LegEntry {
            platform: point(&l.platform),
            base: point(&l.base),
            length: length(l.length),
            length_offset: length(l.length_offset),
            stroke: l.stroke.map(|s| s.map(length)),
            joint: None,
            joint_reversed: false,
            nominal_platform: None,
            nominal_base: None,
            nominal_length_offset: 0.0,
        };
        let six = |q: [f64; 6]| ([length(q[0]), length(q[1]), length(q[2])], [angle(q[3]), angle(q[4]), angle(q[5])]);
        let mut document = self.document.clone();
        for (l, kept) in legs.iter().zip(&mut document.legs) {
            let offset = if kept.nominal_base.is_some() { kept.nominal_length_offset } else { kept.length_offset };
            *kept = LegEntry {
                nominal_platform: kept.nominal_platform.or(Some(kept.platform)),
                nominal_base: kept.nominal_base.or(Some(kept.base)),
                nominal_length_offset: offset,
                joint: kept.joint.take(),
                joint_reversed: kept.joint_reversed,
                ..entry(l)
            };
        }
        let home = |pose: &Pose| {
            let (position, rotation) = six(self.convention.coordinates(pose));
            Some(HomeSection { position, rotation })
        };
        document.home = home(&mechanism.home());
        document.nominal_home = home(&self.commander().home());
        if let Some(w) = workspace {
            let (position, rotation) = six(w.half);
            document.workspace = Some(WorkspaceSection { position, rotation });
        }
        // What is stated on the platform moves with the platform frame.
        let onto_target = frames.target.inverse();
        let moved = |p: &mut [f64; 3]| {
            *p = point(&onto_target.place(&Vector3::from_column_slice(p).map(|v| self.length_unit.to_si(v))));
        };
        if frames.target != Pose::identity() {
            let platform = document.platform.iter_mut();
            platform.flat_map(|s| [&mut s.centre_of_mass, &mut s.payload_centre]).flatten().for_each(moved);
            document.targets.iter_mut().flat_map(|t| &mut t.platform).for_each(moved);
        }
        if !targets.is_empty() {
            let entry =
                |t: &TargetPoint| TargetEntry { name: t.name.clone(), platform: t.platform.as_ref().map(point) };
            document.targets = targets.iter().map(entry).collect();
        }
        Ok(document)
    }
}
