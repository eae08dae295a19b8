//! The mechanism file as it is written: sections, keys and the file's own units.

use serde::{Deserialize, Serialize};

use crate::pose::RotationOrder;

/// A mechanism file, word by word. Numbers are in the units that the file names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MechanismDocument {
    /// What people call the mechanism.
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
    /// The legs in order.
    #[serde(default, rename = "leg")]
    pub legs: Vec<LegEntry>,
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
    /// Masses.
    pub platform: Option<PlatformSection>,
    /// Actuators.
    pub actuator: Option<ActuatorSection>,
    /// Measured points of the platform.
    #[serde(default, rename = "target")]
    pub targets: Vec<TargetEntry>,
    /// Effects of an extended model.
    #[serde(default, rename = "effect")]
    pub effects: Vec<toml::Table>,
}

fn unnamed() -> String {
    "unnamed mechanism".into()
}

/// A horizontal axis of the base.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GravityAxis {
    /// x.
    X,
    /// y.
    Y,
}

/// One `[[leg]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LegEntry {
    /// Point of the platform, platform frame.
    pub platform: [f64; 3],
    /// Point of the base, base frame.
    pub base: [f64; 3],
    /// Length at home.
    pub length: f64,
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
}

/// `[noise]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseSection {
    /// 1σ of a coordinate of a position.
    pub position: f64,
    /// 1σ of an angle.
    pub rotation: f64,
    /// 1σ of a joint reading.
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
        use super::writer::number;
        let list = |v: &[f64]| format!("[{}]", v.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", "));
        let quoted = |s: &str| toml::Value::String(s.into()).to_string();
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
        for leg in &self.legs {
            text += &format!("\n[[leg]]\nplatform = {}\nbase = {}\n", list(&leg.platform), list(&leg.base));
            text += &format!("length = {}\n", number(leg.length));
            if leg.length_offset != 0.0 {
                text += &format!("length_offset = {}\n", number(leg.length_offset));
            }
            if let Some(stroke) = leg.stroke {
                text += &format!("stroke = {}\n", list(&stroke));
            }
            text += &leg.joint.as_ref().map_or(String::new(), |j| format!("joint = {}\n", quoted(j)));
            if leg.joint_reversed {
                text += "joint_reversed = true\n";
            }
            text += &leg.nominal_platform.map_or(String::new(), |v| format!("nominal_platform = {}\n", list(&v)));
            text += &leg.nominal_base.map_or(String::new(), |v| format!("nominal_base = {}\n", list(&v)));
            if leg.nominal_length_offset != 0.0 {
                text += &format!("nominal_length_offset = {}\n", number(leg.nominal_length_offset));
            }
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
        }
        if let Some(s) = &self.noise {
            text += &format!("\n[noise]\nposition = {}\nrotation = {}\n", number(s.position), number(s.rotation));
            if s.joint != 0.0 {
                text += &format!("joint = {}\n", number(s.joint));
            }
        }
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
        for target in &self.targets {
            text += &format!("\n[[target]]\nname = {}\n", quoted(&target.name));
            text += &target.platform.map_or(String::new(), |v| format!("platform = {}\n", list(&v)));
        }
        text
    }
}
