//! The mechanism file as it is written: keys, sections and the file's own units.

use serde::{Deserialize, Serialize};

use crate::files::mechanism::calibration::CalibrationSection;
use crate::files::mechanism::sections::{
    ActuatorSection, CableEntry, DeltaSection, EffectEntry, GravityAxis, HomeSection, LegEntry, MountingSection,
    NoiseSection, OffsetSection, ParameterEntry, PlaneSection, PlatformSection, SensorEntry, TargetEntry,
    ToleranceSection, WorkspaceSection,
};
use crate::pose::RotationOrder;

/// A mechanism file, word by word. Numbers are in the units that the file names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MechanismDocument {
    /// Display name of the mechanism.
    #[serde(default = "unnamed")]
    pub name: String,
    /// Kind of mechanism.
    #[serde(rename = "type")]
    pub kind: String,
    /// Unit of every length: `m`, `mm`, `um`, `in`.
    pub length_unit: String,
    /// Unit of every angle: `rad`, `mrad`, `deg`, `arcsec`.
    pub angle_unit: String,
    /// Order of the rotations, of this file and of its data.
    #[serde(default)]
    pub rotation_order: RotationOrder,
    /// Point of the platform whose position the pose states.
    #[serde(default)]
    pub pivot: [f64; 3],
    /// Horizontal base axis along which gravity lies at elevation 0.
    pub gravity_axis: Option<GravityAxis>,
    /// Temperature at which the geometry holds, °C.
    #[serde(rename = "reference_temperature_degC")]
    pub reference_temperature: Option<f64>,
    /// True if legs really meet in a point of the platform or of the base.
    #[serde(default)]
    pub shared_anchors: bool,
    /// Stems of the parameters that are identified (`["xB", "yB"]`); all if absent. Not for six hardpoints.
    pub identify: Option<Vec<String>>,
    /// The legs in order: rods of a delta, segments of cables.
    #[serde(default, rename = "leg")]
    pub legs: Vec<LegEntry>,
    /// The cables in order.
    #[serde(default, rename = "cable")]
    pub cables: Vec<CableEntry>,
    /// A linear delta by the numbers of its firmware, instead of legs.
    pub delta: Option<DeltaSection>,
    /// In a calibrated file: the same by which poses are commanded.
    pub nominal_delta: Option<DeltaSection>,
    /// In a calibrated file of another kind than six hardpoints: the legs by which poses are commanded.
    #[serde(default, rename = "nominal_leg")]
    pub nominal_legs: Vec<LegEntry>,
    /// In a calibrated file: the cables by which poses are commanded.
    #[serde(default, rename = "nominal_cable")]
    pub nominal_cables: Vec<CableEntry>,
    /// In a calibrated file of a mechanism that a program defines: the values of its parameters.
    #[serde(default, rename = "parameter")]
    pub parameters: Vec<ParameterEntry>,
    /// In a calibrated file of another kind than six hardpoints: the frames of the measurement.
    pub mounting: Option<MountingSection>,
    /// Home pose; solved from the lengths if absent.
    pub home: Option<HomeSection>,
    /// In a calibrated file: the home of the geometry by which poses are commanded.
    pub nominal_home: Option<HomeSection>,
    /// Half-ranges about home.
    pub workspace: Option<WorkspaceSection>,
    /// 1σ of manufacture.
    pub tolerance: Option<ToleranceSection>,
    /// 1σ of the measurement.
    pub noise: Option<NoiseSection>,
    /// The plane over which heights are measured.
    pub plane: Option<PlaneSection>,
    /// Masses.
    pub platform: Option<PlatformSection>,
    /// Actuators.
    pub actuator: Option<ActuatorSection>,
    /// True less commanded coordinates, of a positioner in pose space.
    pub offset: Option<OffsetSection>,
    /// Temperature sensors whose places are known.
    #[serde(default, rename = "sensor")]
    pub sensors: Vec<SensorEntry>,
    /// Measured points of the platform.
    #[serde(default, rename = "target")]
    pub targets: Vec<TargetEntry>,
    /// Effects of an extended model.
    #[serde(default, rename = "effect")]
    pub effects: Vec<EffectEntry>,
    /// In a written file: the calibration that it came from.
    pub calibration: Option<CalibrationSection>,
}

fn unnamed() -> String {
    "unnamed mechanism".into()
}
