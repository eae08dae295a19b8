//! `type = "pose"`: a positioner that is commanded in coordinates of the pose.

use std::any::Any;

use super::file_kind::{FileKind, Made, Source, Target};
use crate::files::error::FileError;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::sections::OffsetSection;
use crate::mechanism::{Mechanism, PosePositioner};

/// A positioner that is commanded in coordinates of the pose.
pub(crate) const KIND: FileKind = FileKind {
    name: "pose",
    label: "a positioner that is commanded in coordinates of the pose",
    needed: &[],
    optional: &[],
    parts: &["[offset]"],
    points_move: false,
    example: Some(include_str!("../examples/pose.toml")),
    read,
    write,
};

fn read(source: &Source<'_>, _warned: &mut Vec<String>) -> Result<Made, FileError> {
    let Source { reader: r, document, convention, home, .. } = *source;
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
            let angle = r.units.angle.to_si(r.known("[tolerance] angle", t.angle.ok_or_else(missing)?)?);
            Some([position, angle])
        }
    };
    let home = convention.pose(&home.unwrap_or_default());
    let made = PosePositioner::new(&document.name, *convention, home, offsets, tolerance);
    Ok((Box::new(made.map_err(|cause| r.geometry(cause))?), None))
}

fn write(mechanism: &dyn Mechanism, target: &Target, document: &mut MechanismDocument) -> bool {
    let Some(positioner) = (mechanism as &dyn Any).downcast_ref::<PosePositioner>() else { return false };
    let mut offsets = [0.0; 6];
    offsets.copy_from_slice(positioner.offsets());
    let (position, rotation) = target.units.six(offsets);
    document.offset = Some(OffsetSection { position, rotation });
    document.home = Some(target.units.home(&target.convention, &positioner.home()));
    true
}
