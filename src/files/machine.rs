//! A mechanism file, read: the mechanism and what else is known about it.

use std::path::PathBuf;
use std::sync::Arc;

use crate::conditions::ConditionTable;
use crate::effect::{ActiveEffect, Catalogue, Environment, without_effects};
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::sections::PlaneSection;
use crate::files::mechanism::units::FileUnits;
use crate::measurement::{Contact, Noise, TargetPoint};
use crate::mechanism::{Mechanism, Workspace};
use crate::pose::{Pose, PoseConvention};
use crate::units::{Dimension, Unit};

/// A mechanism with its environment, SI.
#[derive(Debug)]
pub struct Machine {
    /// Where it came from.
    pub path: PathBuf,
    /// The mechanism.
    pub mechanism: Box<dyn Mechanism>,
    /// The mechanism without its effects, where it is mounted and has some.
    pub(super) plain: Option<Box<dyn Mechanism>>,
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
    /// The effects that its file may state.
    pub(super) catalogue: Catalogue,
    /// The mechanism that files of type "own" mean.
    pub(super) own: Option<Arc<dyn Mechanism>>,
    /// Effects of its file on the measurement.
    pub(super) instrument: Vec<ActiveEffect>,
    /// Unit of its lengths.
    pub length_unit: Unit,
    /// Unit of its angles.
    pub angle_unit: Unit,
    /// Warnings for the user.
    pub warnings: Vec<String>,
    /// The mirror image of a home that the file does not state: the lengths fit it as well.
    pub(super) other_home: Option<Pose>,
    /// Every file that it was read from.
    pub(super) inputs: Vec<PathBuf>,
    pub(super) document: MechanismDocument,
}

impl Machine {
    /// The mechanism without the effects of its file, in the same frames.
    pub fn plain(&self) -> &dyn Mechanism {
        self.plain.as_deref().unwrap_or_else(|| without_effects(self.mechanism.as_ref()))
    }

    /// The effects that its file may state and that a diagnosis looks for.
    pub fn catalogue(&self) -> &Catalogue {
        &self.catalogue
    }

    /// What the covariates of its data mean.
    pub fn condition_kinds(&self) -> &ConditionTable {
        &self.environment.condition_kinds
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
        self.units().of(dimension)
    }

    /// The units of its file.
    pub(super) fn units(&self) -> FileUnits {
        FileUnits { length: self.length_unit, angle: self.angle_unit }
    }

    /// Surroundings of the mechanism as the file states them: masses, screws, sensors, reference temperatures.
    pub fn environment(&self) -> &Arc<Environment> {
        &self.environment
    }

    /// The mechanism by which the controller turns commanded poses into joints. It knows of no effects.
    pub fn commander(&self) -> &dyn Mechanism {
        self.nominal.as_deref().unwrap_or(self.plain())
    }

    /// What there is to say of a home that the file does not state, if the lengths fit its mirror image as well.
    pub fn note_on_home(&self) -> Option<String> {
        let other = self.other_home?;
        let unit = self.length_unit;
        let shown =
            |pose: &Pose| format!("z = {:.3} {}", unit.from_si(pose.place(&self.convention.pivot).z), unit.name);
        Some(format!(
            "[home] is not stated; the lengths fit the platform at {}, which is taken, as well as its mirror image at {}, on \
             the other side of the base (below it, if the machine hangs); state [home] with `position` and `rotation`",
            shown(&self.mechanism.home()),
            shown(&other)
        ))
    }

    /// True if its file says so, or seems to: poses are those of the measurement that it was made from.
    pub(super) fn is_in_frame_of_measurement(&self) -> bool {
        let stated = self.document.calibration.as_ref().and_then(|c| c.frame.as_deref());
        stated.map_or_else(|| self.is_seen_from_elsewhere(), |frame| frame == "measurement")
    }

    /// True if its poses are those of an instrument that stands elsewhere, or of a target that sits elsewhere. The workspace,
    /// a box along the axes of the drawing, then only says how large the moves are.
    pub fn is_seen_from_elsewhere(&self) -> bool {
        let home = self.commander().home();
        let is_outside = |w: &Workspace| w.excess(&home).iter().any(|e| *e > 0.0);
        self.plain().mounting().is_some() || self.workspace.as_ref().is_some_and(is_outside)
    }

    /// The `[plane]` of its file for this contact.
    pub fn plane_section(&self, contact: &Contact) -> PlaneSection {
        PlaneSection::of(contact, self.length_unit)
    }
}
