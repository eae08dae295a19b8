//! Lengths and angles in the units that a file names.

use nalgebra::Vector3;

use crate::files::mechanism::sections::{HomeSection, WorkspaceSection};
use crate::mechanism::Workspace;
use crate::pose::{Pose, PoseConvention};
use crate::units::{Dimension, Unit};

/// The units of one file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FileUnits {
    pub(crate) length: Unit,
    pub(crate) angle: Unit,
}

impl FileUnits {
    /// Unit in which the file writes numbers of a dimension: its own of lengths and angles, otherwise SI.
    pub(crate) fn of(&self, dimension: Dimension) -> Unit {
        match dimension {
            Dimension::Length => self.length,
            Dimension::Angle => self.angle,
            other => Unit::si(other),
        }
    }

    /// A point as the file writes it.
    pub(crate) fn point(&self, p: &Vector3<f64>) -> [f64; 3] {
        [p.x, p.y, p.z].map(|v| self.length.from_si(v))
    }

    /// Three lengths and three angles as the file writes them.
    pub(crate) fn six(&self, q: [f64; 6]) -> ([f64; 3], [f64; 3]) {
        let [x, y, z, rx, ry, rz] = q;
        ([x, y, z].map(|v| self.length.from_si(v)), [rx, ry, rz].map(|v| self.angle.from_si(v)))
    }

    /// A pose as a section such as `[home]` states it.
    pub(crate) fn home(&self, convention: &PoseConvention, pose: &Pose) -> HomeSection {
        let (position, rotation) = self.six(convention.coordinates(pose));
        HomeSection { position, rotation }
    }

    /// The half-ranges of a workspace.
    pub(crate) fn workspace(&self, workspace: &Workspace) -> WorkspaceSection {
        let (position, rotation) = self.six(workspace.half);
        WorkspaceSection { position, rotation }
    }
}
