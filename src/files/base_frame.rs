//! A model of data in a frame of their own, brought back to the frames of its drawing.

use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::identification::{carried_workspace, plausibility};
use crate::measurement::Frames;
use crate::mechanism::Body;

impl Machine {
    /// This machine in the frames of its base and platform instead of those in which it was measured: without the mounting of
    /// its file or, where its points were carried, with base and platform where the rigid motions of all their points say. A
    /// file that is in these frames already stays as it is.
    ///
    /// # Errors
    /// [`FileError`] if there is no mechanism of the carried points.
    pub fn in_base_frame(self) -> Result<Self, FileError> {
        if !self.is_in_frame_of_measurement() {
            return Ok(self);
        }
        let mut document = match self.plain().mounting() {
            Some((base, target)) => {
                let mut document = self.document.clone();
                let back = Frames { base: base.inverse(), target: target.inverse() };
                document.workspace = self.workspace.map(|w| self.units().workspace(&carried_workspace(&w, &back)));
                document.mounting = None;
                document
            }
            None => self.carried_back()?,
        };
        document.calibration = self.document.calibration.clone();
        if let Some(calibration) = &mut document.calibration {
            calibration.frame = Some("base".into());
        }
        self.with_document(document)
    }

    /// The file with the points of base and platform moved back.
    fn carried_back(&self) -> Result<MechanismDocument, FileError> {
        let plain = self.plain();
        let stood = plausibility(self.commander(), plain.values());
        let back = Frames { base: stood.base.inverse(), target: stood.target.inverse() };
        let values = Body::Base.moved(plain, plain.values(), &back.base);
        let values = Body::Platform.moved(plain, &values, &stood.target);
        let home = back.measured(&plain.home());
        let moved =
            plain.with_values(&values, home).map_err(|cause| FileError::Geometry { path: self.path.clone(), cause })?;
        let workspace = self.workspace.map(|w| carried_workspace(&w, &back));
        self.document_of(moved.as_ref(), workspace.as_ref(), &back)
    }
}
