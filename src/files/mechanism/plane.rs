//! `[plane]`: the plane over which heights of the platform's tip are measured.

use nalgebra::Vector3;

use crate::files::error::FileError;
use crate::files::mechanism::reader::Reader;
use crate::files::mechanism::sections::PlaneSection;
use crate::files::table::writer::number;
use crate::measurement::{Contact, Frames, Plane};
use crate::units::Unit;

impl PlaneSection {
    /// The section that states `contact` with lengths in this unit.
    pub(crate) fn of(contact: &Contact, length: Unit) -> Self {
        let tip = contact.tip.map(|v| length.from_si(v));
        Self {
            normal: (*contact.plane.normal).into(),
            distance: length.from_si(contact.plane.distance),
            tip: tip.into(),
            identify: !contact.known,
        }
    }

    /// The section in SI.
    pub(crate) fn read(&self, r: &Reader<'_>) -> Result<Contact, FileError> {
        for v in &self.normal {
            r.finite("[plane] normal", *v)?;
        }
        let distance = r.units.length.to_si(r.finite("[plane] distance", self.distance)?);
        let tip = r.point("[plane] tip", &self.tip)?;
        let plane = Plane::new(&Vector3::from(self.normal), distance).ok_or_else(|| {
            let [x, y, z] = self.normal.map(number);
            let problem = format!("[{x}, {y}, {z}] has no direction; write the normal of the plane, such as [0, 0, 1]");
            r.value("[plane] normal", problem)
        })?;
        Ok(Contact { plane, tip, known: !self.identify })
    }
}

/// A contact transformed into these frames of base and platform.
pub(crate) fn carried(contact: &Contact, frames: &Frames) -> Contact {
    let tip = frames.target.inverse().place(&contact.tip);
    Contact { plane: contact.plane.seen_from(&frames.base), tip, ..*contact }
}
