//! `type = "pose"`: a positioner in pose space, read and written.

use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::entries::OffsetSection;
use crate::files::mechanism::read::{Made, Reader};
use crate::measurement::{Frames, TargetPoint};
use crate::mechanism::{Mechanism, PosePositioner, Workspace};
use crate::pose::PoseConvention;

/// A positioner that is commanded in coordinates of the pose.
pub(crate) fn pose_positioner(
    r: &Reader<'_>,
    document: &MechanismDocument,
    convention: &PoseConvention,
    home: Option<[f64; 6]>,
    _warned: &mut Vec<String>,
) -> Result<Made, FileError> {
    let legs = !document.legs.is_empty() || !document.nominal_legs.is_empty();
    let cables = !document.cables.is_empty() || !document.nominal_cables.is_empty();
    if legs || cables || document.mounting.is_some() || document.identify.is_some() {
        let problem = "[[leg]], [[cable]], [mounting] and identify do not apply to type \"pose\"; delete them";
        return Err(r.value("type", problem));
    }
    if document.noise.as_ref().is_some_and(|n| n.joint != 0.0) {
        return Err(r.value("[noise] joint", "does not apply to type \"pose\", whose joints are commanded; delete it"));
    }
    let offset = document.offset.clone().unwrap_or_default();
    let offsets = r.six("[offset]", &offset.position, &offset.rotation)?;
    let tolerance = match &document.tolerance {
        None => None,
        Some(t) => {
            let (position, _) = r.tolerance(t)?;
            let missing =
                || r.value("[tolerance] angle", "is missing; a mechanism of type \"pose\" needs 1σ of an angle");
            let angle = r.angle.to_si(r.known("[tolerance] angle", t.angle.ok_or_else(missing)?)?);
            Some([position, angle])
        }
    };
    let home = convention.pose(&home.unwrap_or_default());
    let made = PosePositioner::new(&document.name, *convention, home, offsets, tolerance);
    let geometry = |cause| FileError::Geometry { path: r.path.into(), cause };
    Ok((Box::new(made.map_err(geometry)?), None))
}

impl Machine {
    /// The file for another state of a positioner in pose space.
    pub(crate) fn document_of_positioner(
        &self,
        positioner: &PosePositioner,
        workspace: Option<&Workspace>,
        targets: &[TargetPoint],
        frames: &Frames,
    ) -> MechanismDocument {
        let mut document = self.document.clone();
        let mut offsets = [0.0; 6];
        offsets.copy_from_slice(positioner.offsets());
        let (position, rotation) = self.in_units(offsets);
        document.offset = Some(OffsetSection { position, rotation });
        document.home = Some(self.home_section(&positioner.home()));
        document.workspace = workspace.map(|w| self.workspace_section(w)).or(document.workspace);
        self.carry_sections(&mut document, frames);
        self.put_targets(&mut document, targets);
        document
    }
}
