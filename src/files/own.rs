//! Machines of mechanisms that a program defines.

use std::path::Path;

use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::kinds::own::KIND;
use crate::files::mechanism::sections::NoiseSection;
use crate::files::mechanism::units::FileUnits;
use crate::files::read_options::ReadOptions;
use crate::measurement::Noise;
use crate::mechanism::{Mechanism, Workspace};
use crate::units::{Dimension, Unit};

impl Machine {
    /// The machine of a mechanism of your own, so that it has tables, calibrated files and pages like those that come from
    /// a file. Its tables and files are in mm and degrees, and poses are written as those of the workspace.
    ///
    /// A file that is written for it has the type "own" and holds the values of the parameters. It is read by
    /// [`read_with`](Self::read_with) with [`ReadOptions::with_mechanism`].
    ///
    /// # Errors
    /// [`FileError`] if the mechanism cannot be made from its own values.
    pub fn of(
        mechanism: impl Mechanism,
        workspace: Option<&Workspace>,
        noise: Option<&Noise>,
    ) -> Result<Self, FileError> {
        Self::of_with(workspace, noise, &ReadOptions::default().with_mechanism(mechanism))
    }

    /// The machine of the mechanism of these options, with effects and conditions of your own.
    ///
    /// # Errors
    /// [`FileError`] if the options have no mechanism, or if it cannot be made from its own values.
    pub fn of_with(
        workspace: Option<&Workspace>,
        noise: Option<&Noise>,
        options: &ReadOptions,
    ) -> Result<Self, FileError> {
        let unit = |dimension, name| Unit::of(dimension, name).unwrap_or(Unit::si(dimension));
        let units = FileUnits { length: unit(Dimension::Length, "mm"), angle: unit(Dimension::Angle, "deg") };
        let convention = workspace.map(|w| w.convention).unwrap_or_default();
        let mechanism = options.mechanism.as_deref();
        let angles = mechanism.and_then(|m| m.joints().first()).is_some_and(|j| j.dimension == Dimension::Angle);
        let of_joints = if angles { units.angle } else { units.length };
        let document = MechanismDocument {
            name: mechanism.map(Mechanism::name).unwrap_or_default().into(),
            kind: KIND.name.into(),
            length_unit: units.length.name.into(),
            angle_unit: units.angle.name.into(),
            rotation_order: convention.order,
            pivot: units.point(&convention.pivot),
            home: mechanism.map(|m| units.home(&convention, &m.home())),
            workspace: workspace.map(|w| units.workspace(w)),
            noise: noise.filter(|n| n.known).map(|n| NoiseSection {
                position: units.length.from_si(n.position),
                rotation: units.angle.from_si(n.rotation),
                joint: of_joints.from_si(n.joint),
            }),
            ..MechanismDocument::default()
        };
        Self::from_document_with(document, Path::new(KIND.name), options)
    }
}
