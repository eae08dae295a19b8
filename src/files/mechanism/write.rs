//! From a [`Machine`] to the document of another state of the same mechanism.

use std::any::Any;

use nalgebra::Vector3;

use crate::effect::{ActiveEffect, effects_of, without_effects};
use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::kinds;
use crate::files::mechanism::kinds::file_kind::Target;
use crate::files::mechanism::plane::carried;
use crate::files::mechanism::sections::{MountingSection, PlaneSection};
use crate::measurement::Frames;
use crate::mechanism::{Mechanism, Mounted, Workspace};
use crate::pose::Pose;

/// The mechanism that is mounted, where one is.
fn in_own_frames(mechanism: &dyn Mechanism) -> &dyn Mechanism {
    (mechanism as &dyn Any).downcast_ref().map_or(mechanism, Mounted::inner)
}

impl Machine {
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
        frames: &Frames,
    ) -> Result<MechanismDocument, FileError> {
        let mounting = mechanism.mounting();
        // What is mounted keeps its drawing, with everything that stands in it.
        let frames = if mounting.is_some() { &Frames::default() } else { frames };
        let mut document = self.plain_document_of(in_own_frames(without_effects(mechanism)), workspace, frames)?;
        document.mounting = mounting.map(|mounting| MountingSection::of(&self.units(), mounting));
        let effects: Vec<ActiveEffect> = effects_of(mechanism).iter().chain(&self.instrument).cloned().collect();
        document.effects = self.effect_entries(&effects, &[], &self.environment);
        Ok(document)
    }

    /// The document without effects.
    fn plain_document_of(
        &self,
        mechanism: &dyn Mechanism,
        workspace: Option<&Workspace>,
        frames: &Frames,
    ) -> Result<MechanismDocument, FileError> {
        let mut document = self.document.clone();
        // What was said of the geometry as it was does not hold for another.
        document.calibration = None;
        let units = self.units();
        let target = Target { units, convention: self.convention, commanded_home: self.commander().home() };
        let kind = kinds::kind(&document.kind).filter(|kind| (kind.write)(mechanism, &target, &mut document));
        let Some(kind) = kind else {
            return Err(FileError::Value {
                path: self.path.clone(),
                place: "type".into(),
                problem: "a mechanism that does not come from a file cannot be written to one".into(),
            });
        };
        document.workspace = workspace.map(|w| units.workspace(w)).or(document.workspace);
        self.carry_sections(&mut document, frames);
        if kind.points_move {
            self.carry_sensors(&mut document, frames);
        }
        Ok(document)
    }

    /// Transforms the sections of the file: points on the platform follow the platform frame, those on the base the
    /// base frame.
    fn carry_sections(&self, document: &mut MechanismDocument, frames: &Frames) {
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
}
