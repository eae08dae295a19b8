//! The sections of a mechanism file as they are written, in the units that the file names.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::effect::{ScanPoint, label};
use crate::files::error::FileError;
use crate::files::mechanism::reader::Reader;
use crate::files::mechanism::units::FileUnits;
use crate::pose::Pose;

/// A horizontal axis of the base.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GravityAxis {
    /// x.
    #[default]
    X,
    /// y.
    Y,
}

/// One `[[leg]]`. Which keys a kind of mechanism needs is told in `mechanisms/README.md`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LegEntry {
    /// Point of the platform, platform frame.
    pub platform: [f64; 3],
    /// Point of the base, base frame.
    pub base: [f64; 3],
    /// Length at home; of a rod.
    pub length: Option<f64>,
    /// Radius of a crank.
    pub crank: Option<f64>,
    /// Axis of a crank or of a hinge, base frame.
    pub axis: Option<[f64; 3]>,
    /// Where a crank points at angle zero, base frame.
    pub zero: Option<[f64; 3]>,
    /// True crank angle less the commanded one.
    #[serde(default)]
    pub angle_offset: f64,
    /// Two small tilts of a hinge about its nominal axis.
    #[serde(default)]
    pub hinge_tilt: [f64; 2],
    /// Number of the motor whose crank moves a rod, from 1.
    pub motor: Option<usize>,
    /// Radius of the pulley over which a cable comes in at the base.
    pub pulley: Option<f64>,
    /// Direction in which it comes in, along the axis about which the pulley swivels, base frame; +z if absent.
    pub swivel: Option<[f64; 3]>,
    /// Number of the carriage of a rod, from 1.
    pub carriage: Option<usize>,
    /// Direction in which a carriage counts, base frame.
    pub rail: Option<[f64; 3]>,
    /// True length less commanded length.
    #[serde(default)]
    pub length_offset: f64,
    /// Allowed lengths.
    pub stroke: Option<[f64; 2]>,
    /// Name of the leg's joint in a URDF; a data column of this name holds its coordinate, 0 at `length`.
    pub joint: Option<String>,
    /// True if the leg gets shorter as the coordinate of `joint` grows.
    #[serde(default)]
    pub joint_reversed: bool,
    /// In a calibrated file: the platform point by which the controller turns commanded poses into lengths.
    pub nominal_platform: Option<[f64; 3]>,
    /// In a calibrated file: the base point of the same.
    pub nominal_base: Option<[f64; 3]>,
    /// In a calibrated file: the length offset of the same.
    #[serde(default)]
    pub nominal_length_offset: f64,
}

/// One `[[cable]]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CableEntry {
    /// Numbers of the legs that it runs along, from 1; twice for a cable over a pulley.
    pub segments: Vec<usize>,
    /// Radius of its drum; without one the joint is the length of the cable.
    pub drum: Option<f64>,
    /// By how much the radius of the drum grows in one turn.
    pub build_up: Option<f64>,
    /// True change of length since home less the read one.
    #[serde(default)]
    pub length_offset: f64,
    /// Allowed readings.
    pub stroke: Option<[f64; 2]>,
}

/// A number of each tower of `[delta]`, or one for all.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum PerTowerEntry {
    /// One for all three.
    Shared(f64),
    /// One for each.
    Each([f64; 3]),
}

/// `[delta]`: a linear delta by the numbers of its firmware.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeltaSection {
    /// Height of each carriage at coordinate zero.
    pub endstop: PerTowerEntry,
    /// Radius of each tower less that of the effector.
    pub tower_radius: PerTowerEntry,
    /// Direction of each tower, from x to y.
    pub tower_angle: [f64; 3],
    /// Length of each arm.
    pub arm: PerTowerEntry,
    /// Allowed coordinates of the carriages.
    pub stroke: Option<[f64; 2]>,
}

/// One `[[parameter]]` of a mechanism that a program defines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterEntry {
    /// Its name.
    pub name: String,
    /// Its value: a length or an angle in the units of the file, anything else in SI.
    pub value: f64,
}

/// `[mounting]`: where the base stands in the frame of the measurement, and the target on the platform.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MountingSection {
    /// Position of the base.
    pub base_position: [f64; 3],
    /// α β γ of the base.
    pub base_rotation: [f64; 3],
    /// Position of the target.
    pub target_position: [f64; 3],
    /// α β γ of the target.
    pub target_rotation: [f64; 3],
}

impl MountingSection {
    /// Base and target, SI.
    pub(crate) fn read(&self, r: &Reader<'_>) -> Result<[Pose; 2], FileError> {
        let pose = |place: &str, p: &[f64; 3], a: &[f64; 3]| Ok(Pose::from_coordinates(&r.six(place, p, a)?));
        Ok([
            pose("[mounting] base", &self.base_position, &self.base_rotation)?,
            pose("[mounting] target", &self.target_position, &self.target_rotation)?,
        ])
    }

    /// Of base and target.
    pub(crate) fn of(units: &FileUnits, (base, target): (Pose, Pose)) -> Self {
        let (base_position, base_rotation) = units.six(base.coordinates());
        let (target_position, target_rotation) = units.six(target.coordinates());
        Self { base_position, base_rotation, target_position, target_rotation }
    }
}

/// `[home]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HomeSection {
    /// Position.
    pub position: [f64; 3],
    /// α β γ.
    #[serde(default)]
    pub rotation: [f64; 3],
}

/// `[workspace]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorkspaceSection {
    /// Half-ranges of the position.
    pub position: [f64; 3],
    /// Half-ranges of the rotation.
    pub rotation: [f64; 3],
}

/// `[tolerance]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToleranceSection {
    /// 1σ of a coordinate of an anchor.
    pub anchor: f64,
    /// 1σ of a length; that of the anchors if absent.
    pub length: Option<f64>,
    /// 1σ of an angle; that of the anchors over the radius of the platform if absent.
    pub angle: Option<f64>,
}

/// `[noise]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseSection {
    /// 1σ of a coordinate of a position.
    pub position: f64,
    /// 1σ of an angle.
    pub rotation: f64,
    /// 1σ of a joint reading, in the unit of the joints.
    #[serde(default)]
    pub joint: f64,
}

/// `[platform]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlatformSection {
    /// Mass, kg.
    pub mass_kg: Option<f64>,
    /// Centre of mass, platform frame.
    pub centre_of_mass: Option<[f64; 3]>,
    /// Centre of the payload, platform frame.
    pub payload_centre: Option<[f64; 3]>,
}

/// `[actuator]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActuatorSection {
    /// Pitch of the screws.
    pub screw_pitch: Option<f64>,
}

/// One `[[target]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetEntry {
    /// Name: `p1`.
    pub name: String,
    /// Place on the platform; identified if absent.
    pub platform: Option<[f64; 3]>,
}

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

/// One `[[sensor]]`: a temperature sensor at a known place of one of the bodies.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorEntry {
    /// The covariate that holds its readings: its data column without the unit, such as `temp_base1`.
    pub covariate: String,
    /// Where it sits on the platform, platform frame.
    pub platform: Option<[f64; 3]>,
    /// Where it sits on the base, base frame.
    pub base: Option<[f64; 3]>,
}

/// One `[[effect]]`: an effect with values of its parameters, SI.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectEntry {
    /// Name in the catalogue, such as `thermal.legs.uniform`.
    pub name: String,
    /// Leg, from 1.
    pub leg: Option<usize>,
    /// 0-based data row from which on it acts.
    pub row: Option<usize>,
    /// Covariate.
    pub of: Option<String>,
    /// Time constant of the first-order lag with which its temperatures act, s; at once without it.
    pub lag_s: Option<f64>,
    /// Value of each parameter, SI.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
    /// 1σ of parameters, SI; for information.
    #[serde(default)]
    pub sigma: BTreeMap<String, f64>,
    /// Covariates on which it was fitted, with their smallest and largest value, SI and °C.
    #[serde(default)]
    pub range: BTreeMap<String, [f64; 2]>,
    /// Temperatures at which the geometry holds, °C, by covariate; where the file states none for all.
    #[serde(default)]
    pub reference: BTreeMap<String, f64>,
}

/// `[offset]` of a positioner in pose space: true coordinates less the commanded ones.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OffsetSection {
    /// Of the position.
    #[serde(default)]
    pub position: [f64; 3],
    /// Of α β γ.
    #[serde(default)]
    pub rotation: [f64; 3],
}

impl EffectEntry {
    /// Display name, such as `drift.leg[leg=3]`.
    pub fn label(&self) -> String {
        let leg = self.leg.map(|leg| leg.wrapping_sub(1));
        let at = ScanPoint { leg, row: self.row, covariate: self.of.clone(), lag: self.lag_s };
        label(&self.name, &at)
    }
}
