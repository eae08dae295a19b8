//! `[plane]`: the plane over which heights of the platform's tip are measured.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::files::error::FileError;
use crate::files::mechanism::read::Reader;
use crate::files::table::writer::number;
use crate::measurement::{Contact, Frames, Plane};
use crate::units::Unit;

/// `[plane]`. Without it the height of the platform origin over the plane z = 0 of the base is meant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneSection {
    /// Normal, base frame, of any length.
    #[serde(default = "upright")]
    pub normal: [f64; 3],
    /// Distance of the plane from the base origin along the normal.
    #[serde(default)]
    pub distance: f64,
    /// The point whose height is measured, platform frame.
    #[serde(default)]
    pub tip: [f64; 3],
    /// True if the plane is not known and is identified with the parameters.
    #[serde(default)]
    pub identify: bool,
}

fn upright() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

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
        let distance = r.length.to_si(r.finite("[plane] distance", self.distance)?);
        let tip = r.point("[plane] tip", &self.tip)?;
        let plane = Plane::new(&Vector3::from(self.normal), distance).ok_or_else(|| {
            let [x, y, z] = self.normal.map(number);
            let problem = format!("[{x}, {y}, {z}] has no direction; write the normal of the plane, such as [0, 0, 1]");
            r.value("[plane] normal", problem)
        })?;
        Ok(Contact { plane, tip, known: !self.identify })
    }

    /// Its text, with a blank line before it.
    pub(crate) fn to_text(&self) -> String {
        let list = |v: &[f64; 3]| v.map(number).join(", ");
        let mut text = format!("\n[plane]\nnormal = [{}]\ndistance = {}\n", list(&self.normal), number(self.distance));
        text += &format!("tip = [{}]\n", list(&self.tip));
        if self.identify {
            text += "identify = true\n";
        }
        text
    }
}

/// A contact transformed into these frames of base and platform.
pub(crate) fn carried(contact: &Contact, frames: &Frames) -> Contact {
    let tip = frames.target.inverse().place(&contact.tip);
    Contact { plane: contact.plane.seen_from(&frames.base), tip, ..*contact }
}
