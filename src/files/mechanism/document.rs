//! The mechanism file as it is written: sections, keys and the file's own units.

use serde::{Deserialize, Serialize};

use crate::files::PlaneSection;
use crate::files::mechanism::entries::{EffectEntry, OffsetSection, SensorEntry};
use crate::files::table::writer::number;
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
    /// In a calibrated file of another kind than six hardpoints: the legs by which poses are commanded.
    #[serde(default, rename = "nominal_leg")]
    pub nominal_legs: Vec<LegEntry>,
    /// In a calibrated file: the cables by which poses are commanded.
    #[serde(default, rename = "nominal_cable")]
    pub nominal_cables: Vec<CableEntry>,
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
}

fn unnamed() -> String {
    "unnamed mechanism".into()
}

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
    /// True change of length since home less the read one.
    #[serde(default)]
    pub length_offset: f64,
    /// Allowed readings.
    pub stroke: Option<[f64; 2]>,
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

impl MechanismDocument {
    /// The file's text; the same sections in the same order as the format describes them.
    pub fn to_text(&self) -> String {
        let mut text = format!("name = {}\ntype = {}\n", quoted(&self.name), quoted(&self.kind));
        text += &format!("length_unit = \"{}\"\nangle_unit = \"{}\"\n", self.length_unit, self.angle_unit);
        if self.rotation_order != RotationOrder::default() {
            text += "rotation_order = \"xyz\"\n";
        }
        if self.pivot != [0.0; 3] {
            text += &format!("pivot = {}\n", list(&self.pivot));
        }
        if let Some(axis) = self.gravity_axis {
            text += if axis == GravityAxis::X { "gravity_axis = \"x\"\n" } else { "gravity_axis = \"y\"\n" };
        }
        if let Some(t) = self.reference_temperature {
            text += &format!("reference_temperature_degC = {}\n", number(t));
        }
        if self.shared_anchors {
            text += "shared_anchors = true\n";
        }
        if let Some(stems) = &self.identify {
            let stems: Vec<String> = stems.iter().map(|s| quoted(s)).collect();
            text += &format!("identify = [{}]\n", stems.join(", "));
        }
        for (name, legs) in [("leg", &self.legs), ("nominal_leg", &self.nominal_legs)] {
            legs.iter().for_each(|leg| text += &leg.to_text(name));
        }
        for (name, cables) in [("cable", &self.cables), ("nominal_cable", &self.nominal_cables)] {
            cables.iter().for_each(|cable| text += &cable.to_text(name));
        }
        if let Some(m) = &self.mounting {
            text += &format!("\n[mounting]\nbase_position = {}\n", list(&m.base_position));
            text += &format!("base_rotation = {}\n", list(&m.base_rotation));
            text += &format!("target_position = {}\n", list(&m.target_position));
            text += &format!("target_rotation = {}\n", list(&m.target_rotation));
        }
        for (name, section) in [("home", &self.home), ("nominal_home", &self.nominal_home)] {
            if let Some(s) = section {
                text += &format!("\n[{name}]\nposition = {}\nrotation = {}\n", list(&s.position), list(&s.rotation));
            }
        }
        if let Some(s) = &self.workspace {
            text += &format!("\n[workspace]\nposition = {}\nrotation = {}\n", list(&s.position), list(&s.rotation));
        }
        if let Some(s) = &self.tolerance {
            text += &format!("\n[tolerance]\nanchor = {}\n", number(s.anchor));
            text += &s.length.map_or(String::new(), |v| format!("length = {}\n", number(v)));
            text += &s.angle.map_or(String::new(), |v| format!("angle = {}\n", number(v)));
        }
        if let Some(s) = &self.noise {
            text += &format!("\n[noise]\nposition = {}\nrotation = {}\n", number(s.position), number(s.rotation));
            if s.joint != 0.0 {
                text += &format!("joint = {}\n", number(s.joint));
            }
        }
        text += &self.plane.as_ref().map_or(String::new(), PlaneSection::to_text);
        if let Some(s) = &self.platform {
            text += "\n[platform]\n";
            text += &s.mass_kg.map_or(String::new(), |v| format!("mass_kg = {}\n", number(v)));
            text += &s.centre_of_mass.map_or(String::new(), |v| format!("centre_of_mass = {}\n", list(&v)));
            text += &s.payload_centre.map_or(String::new(), |v| format!("payload_centre = {}\n", list(&v)));
        }
        if let Some(s) = &self.actuator {
            text += "\n[actuator]\n";
            text += &s.screw_pitch.map_or(String::new(), |v| format!("screw_pitch = {}\n", number(v)));
        }
        text += &self.offset.as_ref().map_or(String::new(), OffsetSection::to_text);
        self.sensors.iter().for_each(|sensor| text += &sensor.to_text());
        for target in &self.targets {
            text += &format!("\n[[target]]\nname = {}\n", quoted(&target.name));
            text += &target.platform.map_or(String::new(), |v| format!("platform = {}\n", list(&v)));
        }
        self.effects.iter().for_each(|effect| text += &effect.to_text());
        text
    }
}

pub(crate) fn list(values: &[f64]) -> String {
    format!("[{}]", values.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", "))
}

pub(crate) fn quoted(text: &str) -> String {
    toml::Value::String(text.into()).to_string()
}

/// The line of a key that may be left out.
pub(crate) fn line(key: &str, value: Option<String>) -> String {
    value.map_or(String::new(), |v| format!("{key} = {v}\n"))
}

impl LegEntry {
    fn to_text(&self, section: &str) -> String {
        let not_zero = |v: f64| (v != 0.0).then(|| number(v));
        let mut text = format!("\n[[{section}]]\nplatform = {}\nbase = {}\n", list(&self.platform), list(&self.base));
        text += &line("length", self.length.map(number));
        text += &line("length_offset", not_zero(self.length_offset));
        text += &line("crank", self.crank.map(number));
        text += &line("axis", self.axis.map(|v| list(&v)));
        text += &line("zero", self.zero.map(|v| list(&v)));
        text += &line("angle_offset", not_zero(self.angle_offset));
        text += &line("hinge_tilt", (self.hinge_tilt != [0.0; 2]).then(|| list(&self.hinge_tilt)));
        text += &line("carriage", self.carriage.map(|k| k.to_string()));
        text += &line("rail", self.rail.map(|v| list(&v)));
        text += &line("stroke", self.stroke.map(|v| list(&v)));
        text += &line("joint", self.joint.as_ref().map(|j| quoted(j)));
        text += &line("joint_reversed", self.joint_reversed.then(|| "true".into()));
        text += &line("nominal_platform", self.nominal_platform.map(|v| list(&v)));
        text += &line("nominal_base", self.nominal_base.map(|v| list(&v)));
        text + &line("nominal_length_offset", not_zero(self.nominal_length_offset))
    }
}

impl CableEntry {
    fn to_text(&self, section: &str) -> String {
        let segments: Vec<String> = self.segments.iter().map(usize::to_string).collect();
        let mut text = format!("\n[[{section}]]\nsegments = [{}]\n", segments.join(", "));
        text += &line("drum", self.drum.map(number));
        text += &line("length_offset", (self.length_offset != 0.0).then(|| number(self.length_offset)));
        text + &line("stroke", self.stroke.map(|v| list(&v)))
    }
}
