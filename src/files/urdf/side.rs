//! The side file of a URDF: what URDF cannot say, in TOML.

use std::collections::HashMap;
use std::path::Path;

use serde::Deserialize;

use crate::files::error::FileError;
use crate::files::mechanism::calibration::CalibrationSection;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::kinds::six_hardpoint::KIND;
use crate::files::mechanism::sections::{
    ActuatorSection, EffectEntry, GravityAxis, HomeSection, NoiseSection, PlaneSection, PlatformSection, SensorEntry,
    TargetEntry, ToleranceSection, WorkspaceSection,
};
use crate::pose::RotationOrder;

/// A TOML file beside a URDF, word by word. Lengths and angles are in the units that it names, m and rad if it names
/// none.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SideDocument {
    /// The URDF, by its path from this file; whoever reads this file has looked at it already.
    #[serde(rename = "urdf")]
    _urdf: Option<String>,
    /// Pairs of links or joints whose frames coincide, each with a kind (`ball`, `fixed`) if it is known.
    #[serde(default)]
    pub(super) close: Vec<Vec<String>>,
    pub(super) base_link: Option<String>,
    pub(super) platform_link: Option<String>,
    /// Joint coordinates of the assembled home, in the units of this file.
    #[serde(default)]
    pub(super) home_joints: HashMap<String, f64>,
    /// True less commanded length of each leg, in the order of the slides.
    length_offsets: Option<Vec<f64>>,
    /// Commanded lengths of each leg, shortest and longest, or `[]`; they replace the limits of the slides.
    pub(super) strokes: Option<Vec<Vec<f64>>>,
    name: Option<String>,
    #[serde(rename = "type")]
    kind: Option<String>,
    length_unit: Option<String>,
    angle_unit: Option<String>,
    #[serde(default)]
    rotation_order: RotationOrder,
    #[serde(default)]
    pivot: [f64; 3],
    gravity_axis: Option<GravityAxis>,
    #[serde(rename = "reference_temperature_degC")]
    reference_temperature: Option<f64>,
    #[serde(default)]
    shared_anchors: bool,
    pub(super) home: Option<HomeSection>,
    workspace: Option<WorkspaceSection>,
    tolerance: Option<ToleranceSection>,
    noise: Option<NoiseSection>,
    platform: Option<PlatformSection>,
    actuator: Option<ActuatorSection>,
    plane: Option<PlaneSection>,
    #[serde(default, rename = "target")]
    targets: Vec<TargetEntry>,
    #[serde(default, rename = "effect")]
    effects: Vec<EffectEntry>,
    calibration: Option<CalibrationSection>,
    #[serde(default, rename = "sensor")]
    sensors: Vec<SensorEntry>,
}

/// Values that a side file states for each leg, in its own unit.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PerLeg {
    /// True less commanded length.
    pub(super) offsets: Option<[f64; 6]>,
    /// Commanded lengths; `None` for a leg without limits.
    pub(super) strokes: Option<[Option<[f64; 2]>; 6]>,
}

pub(super) fn toml_error(path: &Path, message: &str) -> FileError {
    FileError::Toml { path: path.into(), message: message.trim_end().to_owned() }
}

/// True if a YAML text states closures or motors; other files of that name are configurations of other programs.
pub(super) fn is_closure_yaml(text: &str) -> bool {
    let keys = ["closed_loop", "name_mot", "joint_name"];
    text.lines().any(|line| keys.iter().any(|k| line.strip_prefix(k).is_some_and(|r| r.trim_start().starts_with(':'))))
}

/// True if a name that stands in a file means this URDF.
pub(super) fn names(file: &Path, name: &str, urdf: &Path) -> bool {
    let named = file.parent().unwrap_or(Path::new("")).join(name);
    let resolved = |path: &Path| std::fs::canonicalize(path).ok();
    named == urdf || resolved(&named).is_some_and(|named| Some(named) == resolved(urdf))
}

pub(super) fn parse(text: &str, path: &Path) -> Result<SideDocument, FileError> {
    let document: SideDocument = toml::from_str(text).map_err(|e| toml_error(path, &e.to_string()))?;
    if let Some(kind) = document.kind.as_ref().filter(|k| *k != KIND.name) {
        let problem = format!("'{kind}' cannot be read from URDF; only \"{}\" can", KIND.name);
        return Err(FileError::Value { path: path.into(), place: "type".into(), problem });
    }
    Ok(document)
}

impl SideDocument {
    /// Per-leg numbers of the side file, in its own unit.
    pub(super) fn per_leg(&self, path: &Path) -> Result<PerLeg, FileError> {
        let wrong = |place: &str, problem: &str| FileError::Value {
            path: path.into(),
            place: place.into(),
            problem: problem.into(),
        };
        let six = "needs six entries, one for each leg in the order of the slides in the URDF";
        let offsets = self
            .length_offsets
            .as_ref()
            .map(|list| <[f64; 6]>::try_from(list.clone()).map_err(|_| wrong("length_offsets", six)));
        let strokes = self.strokes.as_ref().map(|list| {
            let one = |s: &Vec<f64>| match s[..] {
                [] => Ok(None),
                [from, to] => Ok(Some([from, to])),
                _ => Err(wrong("strokes", "each entry is [shortest, longest] length, or [] for none")),
            };
            let list = list.iter().map(one).collect::<Result<Vec<_>, _>>()?;
            <[Option<[f64; 2]>; 6]>::try_from(list).map_err(|_| wrong("strokes", six))
        });
        Ok(PerLeg { offsets: offsets.transpose()?, strokes: strokes.transpose()? })
    }

    /// The document without its legs.
    pub(super) fn into_document(self, robot: &str) -> MechanismDocument {
        let named = if robot.is_empty() { "unnamed mechanism" } else { robot };
        MechanismDocument {
            name: self.name.unwrap_or_else(|| named.into()),
            kind: KIND.name.into(),
            length_unit: self.length_unit.unwrap_or_else(|| "m".into()),
            angle_unit: self.angle_unit.unwrap_or_else(|| "rad".into()),
            rotation_order: self.rotation_order,
            pivot: self.pivot,
            gravity_axis: self.gravity_axis,
            reference_temperature: self.reference_temperature,
            shared_anchors: self.shared_anchors,
            home: self.home,
            workspace: self.workspace,
            tolerance: self.tolerance,
            noise: self.noise,
            platform: self.platform,
            actuator: self.actuator,
            plane: self.plane,
            targets: self.targets,
            calibration: self.calibration,
            effects: self.effects,
            sensors: self.sensors,
            // A URDF states six legs, and no file that a calibration wrote.
            ..MechanismDocument::default()
        }
    }
}
