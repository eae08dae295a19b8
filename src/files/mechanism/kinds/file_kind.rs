//! What the reading and writing of mechanism files knows of one kind.

use crate::files::error::FileError;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::reader::Reader;
use crate::files::mechanism::sections::LegEntry;
use crate::files::mechanism::units::FileUnits;
use crate::mechanism::Mechanism;
use crate::pose::{Pose, PoseConvention};

/// A kind of mechanism in files.
pub(crate) struct FileKind {
    /// `type` in the file.
    pub(crate) name: &'static str,
    /// What it is, for people.
    pub(crate) label: &'static str,
    /// Keys of a leg beside `platform` and `base` that it needs.
    pub(crate) needed: &'static [&'static str],
    /// Keys of a leg that it may have.
    pub(crate) optional: &'static [&'static str],
    /// Parts of the file that only some kinds have and that it may have; see [`special_parts`].
    pub(crate) parts: &'static [&'static str],
    /// True if its points are written in the frames of a measurement, so that sensors go along; others keep the
    /// frames of the drawing.
    pub(crate) points_move: bool,
    /// A file of this kind with comments on every key; `None` if a file alone does not make one.
    pub(crate) example: Option<&'static str>,
    /// Reads it; what the user should know is added to the warnings.
    pub(crate) read: fn(&Source<'_>, &mut Vec<String>) -> Result<Made, FileError>,
    /// Writes a mechanism of this kind into a document of this kind: legs, cables, offsets, home and mounting. False
    /// if the mechanism is of another kind.
    pub(crate) write: fn(&dyn Mechanism, &Target, &mut MechanismDocument) -> bool,
}

/// What a kind is read from.
pub(crate) struct Source<'a> {
    pub(crate) reader: &'a Reader<'a>,
    pub(crate) document: &'a MechanismDocument,
    pub(crate) convention: &'a PoseConvention,
    /// Coordinates of `[home]`, SI.
    pub(crate) home: Option<[f64; 6]>,
    /// The mechanism that the reading program defines.
    pub(crate) own: Option<&'a dyn Mechanism>,
}

/// A mechanism and, if the file keeps them apart, the one by which the controller turns poses into joints.
pub(crate) type Made = (Box<dyn Mechanism>, Option<Box<dyn Mechanism>>);

/// How a kind is written.
pub(crate) struct Target {
    pub(crate) units: FileUnits,
    pub(crate) convention: PoseConvention,
    /// Home of the mechanism by which the controller turns poses into joints.
    pub(crate) commanded_home: Pose,
}

/// Parts of a file that mean nothing for some kinds, and whether a document has them.
fn special_parts(document: &MechanismDocument) -> [(&'static str, bool); 10] {
    [
        ("[[leg]]", !document.legs.is_empty()),
        ("[delta]", document.delta.is_some()),
        ("[nominal_delta]", document.nominal_delta.is_some()),
        ("[[cable]]", !document.cables.is_empty()),
        ("[[nominal_leg]]", !document.nominal_legs.is_empty()),
        ("[[nominal_cable]]", !document.nominal_cables.is_empty()),
        ("[mounting]", document.mounting.is_some()),
        ("identify", document.identify.is_some()),
        ("[offset]", document.offset.is_some()),
        ("[[parameter]]", !document.parameters.is_empty()),
    ]
}

impl FileKind {
    /// Refuses parts of a document that mean nothing for this kind.
    pub(crate) fn check_parts(&self, r: &Reader<'_>, document: &MechanismDocument) -> Result<(), FileError> {
        let stranger = special_parts(document).into_iter().find(|(part, stated)| *stated && !self.parts.contains(part));
        match stranger {
            Some((part, _)) => Err(r.value(part, format!("does not apply to type \"{}\"; delete it", self.name))),
            None => Ok(()),
        }
    }

    /// Refuses legs that lack a key of their kind or have one that means nothing for it.
    pub(crate) fn check_keys(&self, r: &Reader<'_>, legs: &[LegEntry]) -> Result<(), FileError> {
        let Self { name: kind, needed, optional, .. } = self;
        for (i, leg) in legs.iter().enumerate() {
            let nominal =
                leg.nominal_platform.is_some() || leg.nominal_base.is_some() || leg.nominal_length_offset != 0.0;
            let stated = [
                ("length", leg.length.is_some()),
                ("crank", leg.crank.is_some()),
                ("axis", leg.axis.is_some()),
                ("zero", leg.zero.is_some()),
                ("motor", leg.motor.is_some()),
                ("pulley", leg.pulley.is_some()),
                ("swivel", leg.swivel.is_some()),
                ("carriage", leg.carriage.is_some()),
                ("rail", leg.rail.is_some()),
                ("length_offset", leg.length_offset != 0.0),
                ("angle_offset", leg.angle_offset != 0.0),
                ("hinge_tilt", leg.hinge_tilt != [0.0; 2]),
                ("stroke", leg.stroke.is_some()),
                ("nominal", nominal),
            ];
            for (key, stated) in stated {
                let place = || format!("leg {}, `{key}`", i + 1);
                if needed.contains(&key) && !stated {
                    return Err(r.value(place(), format!("is missing; a leg of type \"{kind}\" needs it")));
                }
                if stated && !needed.contains(&key) && !optional.contains(&key) {
                    return Err(r.value(place(), format!("does not apply to type \"{kind}\"; delete it")));
                }
            }
        }
        Ok(())
    }
}
