//! A mechanism file, read: the mechanism and what else is known about it.

use std::any::Any;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::Vector3;

use crate::effect::{ActiveEffect, Environment, effects_of, without_effects};
use crate::files::error::{FileError, read_text};
use crate::files::mechanism::document::{
    HomeSection, LegEntry, MechanismDocument, MountingSection, TargetEntry, WorkspaceSection,
};
use crate::files::mechanism::kinds::{self, Parts, parts};
use crate::files::mechanism::plane::{PlaneSection, carried};
use crate::files::mechanism::read::{Reader, build};
use crate::files::urdf::{self, UrdfOptions};
use crate::measurement::{Contact, Frames, Noise, TargetPoint};
use crate::mechanism::{GeometryError, Leg, Mechanism, PosePositioner, SixHardpoint, Workspace};
use crate::pose::{Pose, PoseConvention};
use crate::units::{Dimension, Unit};

/// The paper's kind of mechanism.
pub(super) const SIX_HARDPOINT: &str = "six-hardpoint";
/// A positioner that is commanded in coordinates of the pose.
pub(super) const POSE: &str = "pose";

/// A mechanism with its environment, SI.
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
    /// The plane over which heights are measured, and of which point.
    pub contact: Contact,
    /// Surroundings of the mechanism.
    pub(super) environment: Arc<Environment>,
    /// Effects of its file on the measurement.
    pub(super) instrument: Vec<ActiveEffect>,
    /// Unit of its lengths.
    pub length_unit: Unit,
    /// Unit of its angles.
    pub angle_unit: Unit,
    /// Warnings for the user.
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

    /// Reads a mechanism file, with options that supply what a URDF file lacks.
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
            let problem = "closures, links and joint coordinates are for URDF files only, and this is not one";
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
            let problem = format!("is missing; this file belongs to '{}', name that one", robot.display());
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

    /// Unit in which its files write numbers of a dimension: the stated one of lengths and angles, otherwise SI.
    pub fn unit(&self, dimension: Dimension) -> Unit {
        match dimension {
            Dimension::Length => self.length_unit,
            Dimension::Angle => self.angle_unit,
            other => Unit::si(other),
        }
    }

    /// Surroundings of the mechanism as the file states them: masses, screws, sensors, reference temperatures.
    pub fn environment(&self) -> &Arc<Environment> {
        &self.environment
    }

    /// The mechanism by which the controller turns commanded poses into joints. It knows of no effects.
    pub fn commander(&self) -> &dyn Mechanism {
        self.nominal.as_deref().unwrap_or(self.plain())
    }

    /// The `[plane]` of its file for this contact.
    pub fn plane_section(&self, contact: &Contact) -> PlaneSection {
        PlaneSection::of(contact, self.length_unit)
    }

    /// The file for another state of the same mechanism: calibrated values, home and workspace in SI, and targets
    /// whose places were identified. `frames` are those that `mechanism` was carried into; what the file states on the
    /// platform goes along. The effects are those around `mechanism` and those of the file on the measurement. Other
    /// sections are kept.
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
        let mut document = self.plain_document_of(without_effects(mechanism), workspace, targets, frames)?;
        let effects: Vec<ActiveEffect> = effects_of(mechanism).iter().chain(&self.instrument).cloned().collect();
        document.effects = self.effect_entries(&effects, &[], &self.environment);
        Ok(document)
    }

    /// Document of a calibrated mechanism without its effects.
    fn plain_document_of(
        &self,
        mechanism: &dyn Mechanism,
        workspace: Option<&Workspace>,
        targets: &[TargetPoint],
        frames: &Frames,
    ) -> Result<MechanismDocument, FileError> {
        if let Some(parts) = parts(mechanism) {
            return Ok(self.document_of_parts(&parts, workspace, targets, frames));
        }
        if let Some(positioner) = (mechanism as &dyn Any).downcast_ref::<PosePositioner>() {
            return Ok(self.document_of_positioner(positioner, workspace, targets, frames));
        }
        let Some(legs) = (mechanism as &dyn Any).downcast_ref::<SixHardpoint>().map(SixHardpoint::to_legs) else {
            return Err(FileError::Value {
                path: self.path.clone(),
                place: "type".into(),
                problem: "a mechanism that does not come from a file cannot be written to one".into(),
            });
        };
        let length = |v: f64| self.length_unit.from_si(v);
        let point = |p: &Vector3<f64>| [length(p.x), length(p.y), length(p.z)];
        let entry = |l: &Leg| LegEntry {
            platform: point(&l.platform),
            base: point(&l.base),
            length: Some(length(l.length)),
            length_offset: length(l.length_offset),
            stroke: l.stroke.map(|s| s.map(length)),
            ..LegEntry::default()
        };
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
        document.home = Some(self.home_section(&mechanism.home()));
        document.nominal_home = Some(self.home_section(&self.commander().home()));
        document.workspace = workspace.map(|w| self.workspace_section(w)).or(document.workspace);
        self.carry_sections(&mut document, frames);
        self.carry_sensors(&mut document, frames);
        self.put_targets(&mut document, targets);
        Ok(document)
    }

    /// Document of a mechanism made from a closure: it keeps the frames of its drawing and is mounted in those of the
    /// measurement.
    fn document_of_parts(
        &self,
        parts: &Parts,
        workspace: Option<&Workspace>,
        targets: &[TargetPoint],
        frames: &Frames,
    ) -> MechanismDocument {
        let mut document = self.document.clone();
        if document.nominal_legs.is_empty() {
            document.nominal_legs = document.legs.clone();
            document.nominal_cables = document.cables.clone();
            document.nominal_home = document.home.clone();
        }
        let units = Reader { path: &self.path, length: self.length_unit, angle: self.angle_unit };
        kinds::write(&parts.values, &units, &mut document.legs, &mut document.cables);
        document.home = Some(self.home_section(&parts.home));
        document.workspace = workspace.map(|w| self.workspace_section(w)).or(document.workspace);
        document.mounting = parts.mounting.map(|(base, target)| {
            let (base_position, base_rotation) = self.in_units(base.coordinates());
            let (target_position, target_rotation) = self.in_units(target.coordinates());
            MountingSection { base_position, base_rotation, target_position, target_rotation }
        });
        self.carry_sections(&mut document, frames);
        self.put_targets(&mut document, targets);
        document
    }

    /// Transforms the sections of the file: points on the platform follow the platform frame, those on the base the
    /// base frame.
    pub(super) fn carry_sections(&self, document: &mut MechanismDocument, frames: &Frames) {
        let onto_target = frames.target.inverse();
        let moved = |p: &mut [f64; 3]| self.move_point(p, &onto_target);
        if frames.target != Pose::identity() {
            let platform = document.platform.iter_mut();
            platform.flat_map(|s| [&mut s.centre_of_mass, &mut s.payload_centre]).flatten().for_each(moved);
            document.targets.iter_mut().flat_map(|t| &mut t.platform).for_each(moved);
        }
        if let Some(section) = document.plane.as_mut().filter(|_| !frames.is_identity()) {
            *section = PlaneSection::of(&carried(&self.contact, frames), self.length_unit);
        }
    }

    /// Sensors sit where the points of their body are stated.
    fn carry_sensors(&self, document: &mut MechanismDocument, frames: &Frames) {
        let onto_target = frames.target.inverse();
        for sensor in document.sensors.iter_mut().filter(|_| !frames.is_identity()) {
            sensor.platform.iter_mut().for_each(|p| self.move_point(p, &onto_target));
            sensor.base.iter_mut().for_each(|p| self.move_point(p, &frames.base));
        }
    }

    fn move_point(&self, p: &mut [f64; 3], motion: &Pose) {
        let place = Vector3::from_column_slice(p).map(|v| self.length_unit.to_si(v));
        *p = motion.place(&place).map(|v| self.length_unit.from_si(v)).into();
    }

    pub(super) fn in_units(&self, q: [f64; 6]) -> ([f64; 3], [f64; 3]) {
        let length = |k: usize| self.length_unit.from_si(q[k]);
        let angle = |k: usize| self.angle_unit.from_si(q[k]);
        ([length(0), length(1), length(2)], [angle(3), angle(4), angle(5)])
    }

    pub(super) fn home_section(&self, pose: &Pose) -> HomeSection {
        let (position, rotation) = self.in_units(self.convention.coordinates(pose));
        HomeSection { position, rotation }
    }

    pub(super) fn workspace_section(&self, workspace: &Workspace) -> WorkspaceSection {
        let (position, rotation) = self.in_units(workspace.half);
        WorkspaceSection { position, rotation }
    }

    pub(super) fn put_targets(&self, document: &mut MechanismDocument, targets: &[TargetPoint]) {
        let point = |p: &Vector3<f64>| [p.x, p.y, p.z].map(|v| self.length_unit.from_si(v));
        let entry = |t: &TargetPoint| TargetEntry { name: t.name.clone(), platform: t.platform.as_ref().map(point) };
        if !targets.is_empty() {
            document.targets = targets.iter().map(entry).collect();
        }
    }
}
