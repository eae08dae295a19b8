//! A mechanism file as text: the sections in the order in which the format describes them.

use std::collections::BTreeMap;

use crate::files::mechanism::calibration::CalibrationSection;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::sections::{
    CableEntry, DeltaSection, EffectEntry, GravityAxis, LegEntry, OffsetSection, PerTowerEntry, PlaneSection,
    SensorEntry,
};
use crate::files::table::writer::number;
use crate::pose::RotationOrder;

impl MechanismDocument {
    /// The file's text; the same sections in the same order as the format describes them.
    pub fn to_text(&self) -> String {
        let comment = self
            .calibration
            .as_ref()
            .map_or_else(String::new, |c| format!("# Calibrated or extended {}; see [calibration].\n", c.in_words()));
        comment + &self.keys() + &self.geometry() + &self.measurement()
    }

    /// The keys before the first section.
    fn keys(&self) -> String {
        let mut text = line("name", Some(quoted(&self.name)));
        text += &line("type", Some(quoted(&self.kind)));
        text += &line("length_unit", Some(quoted(&self.length_unit)));
        text += &line("angle_unit", Some(quoted(&self.angle_unit)));
        text += &line("rotation_order", (self.rotation_order != RotationOrder::default()).then(|| quoted("xyz")));
        text += &line("pivot", (self.pivot != [0.0; 3]).then(|| list(&self.pivot)));
        text += &line("gravity_axis", self.gravity_axis.map(|a| quoted(if a == GravityAxis::X { "x" } else { "y" })));
        text += &line("reference_temperature_degC", self.reference_temperature.map(number));
        text += &line("shared_anchors", self.shared_anchors.then(|| "true".into()));
        let stems = |stems: &Vec<String>| stems.iter().map(|s| quoted(s)).collect::<Vec<_>>().join(", ");
        text + &line("identify", self.identify.as_ref().map(|s| format!("[{}]", stems(s))))
    }

    /// Legs, cables, and where things stand.
    fn geometry(&self) -> String {
        let mut text = String::new();
        for (name, legs) in [("leg", &self.legs), ("nominal_leg", &self.nominal_legs)] {
            legs.iter().for_each(|leg| text += &leg.to_text(name));
        }
        for (name, cables) in [("cable", &self.cables), ("nominal_cable", &self.nominal_cables)] {
            cables.iter().for_each(|cable| text += &cable.to_text(name));
        }
        for (name, delta) in [("delta", &self.delta), ("nominal_delta", &self.nominal_delta)] {
            delta.iter().for_each(|delta| text += &delta.to_text(name));
        }
        for p in &self.parameters {
            text += &format!("\n[[parameter]]\nname = {}\nvalue = {}\n", quoted(&p.name), number(p.value));
        }
        if let Some(m) = &self.mounting {
            text += "\n[mounting]\n";
            text += &line("base_position", Some(list(&m.base_position)));
            text += &line("base_rotation", Some(list(&m.base_rotation)));
            text += &line("target_position", Some(list(&m.target_position)));
            text += &line("target_rotation", Some(list(&m.target_rotation)));
        }
        let six = |name: &str, position: &[f64; 3], rotation: &[f64; 3]| {
            format!("\n[{name}]\nposition = {}\nrotation = {}\n", list(position), list(rotation))
        };
        for (name, section) in [("home", &self.home), ("nominal_home", &self.nominal_home)] {
            text += &section.as_ref().map_or(String::new(), |s| six(name, &s.position, &s.rotation));
        }
        text + &self.workspace.as_ref().map_or(String::new(), |s| six("workspace", &s.position, &s.rotation))
    }

    /// What is known of manufacture and measurement, and what acts on the mechanism.
    fn measurement(&self) -> String {
        let mut text = String::new();
        if let Some(s) = &self.tolerance {
            text += "\n[tolerance]\n";
            text += &line("anchor", Some(number(s.anchor)));
            text += &line("length", s.length.map(number));
            text += &line("angle", s.angle.map(number));
        }
        if let Some(s) = &self.noise {
            text += "\n[noise]\n";
            text += &line("position", Some(number(s.position)));
            text += &line("rotation", Some(number(s.rotation)));
            text += &line("joint", (s.joint != 0.0).then(|| number(s.joint)));
        }
        text += &self.plane.as_ref().map_or(String::new(), PlaneSection::to_text);
        if let Some(s) = &self.platform {
            text += "\n[platform]\n";
            text += &line("mass_kg", s.mass_kg.map(number));
            text += &line("centre_of_mass", s.centre_of_mass.map(|v| list(&v)));
            text += &line("payload_centre", s.payload_centre.map(|v| list(&v)));
        }
        if let Some(s) = &self.actuator {
            text += "\n[actuator]\n";
            text += &line("screw_pitch", s.screw_pitch.map(number));
        }
        text += &self.offset.as_ref().map_or(String::new(), OffsetSection::to_text);
        self.sensors.iter().for_each(|sensor| text += &sensor.to_text());
        for target in &self.targets {
            text += "\n[[target]]\n";
            text += &line("name", Some(quoted(&target.name)));
            text += &line("platform", target.platform.map(|v| list(&v)));
        }
        self.effects.iter().for_each(|effect| text += &effect.to_text());
        text + &self.calibration.as_ref().map_or(String::new(), CalibrationSection::to_text)
    }
}

pub(super) fn list(values: &[f64]) -> String {
    format!("[{}]", values.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", "))
}

pub(super) fn quoted(text: &str) -> String {
    toml::Value::String(text.into()).to_string()
}

/// The line of a key that may be left out.
pub(super) fn line(key: &str, value: Option<String>) -> String {
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
        text += &line("motor", self.motor.map(|k| k.to_string()));
        text += &line("pulley", self.pulley.map(number));
        text += &line("swivel", self.swivel.map(|v| list(&v)));
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
        text += &line("build_up", self.build_up.map(number));
        text += &line("length_offset", (self.length_offset != 0.0).then(|| number(self.length_offset)));
        text + &line("stroke", self.stroke.map(|v| list(&v)))
    }
}

impl DeltaSection {
    fn to_text(self, section: &str) -> String {
        let per_tower = |entry: PerTowerEntry| match entry {
            PerTowerEntry::Shared(value) => number(value),
            PerTowerEntry::Each(values) => list(&values),
        };
        let mut text = format!("\n[{section}]\n");
        text += &line("endstop", Some(per_tower(self.endstop)));
        text += &line("tower_radius", Some(per_tower(self.tower_radius)));
        text += &line("tower_angle", Some(list(&self.tower_angle)));
        text += &line("arm", Some(per_tower(self.arm)));
        text + &line("stroke", self.stroke.map(|v| list(&v)))
    }
}

impl PlaneSection {
    /// Its text, with a blank line before it.
    pub(crate) fn to_text(&self) -> String {
        let mut text = String::from("\n[plane]\n");
        text += &line("normal", Some(list(&self.normal)));
        text += &line("distance", Some(number(self.distance)));
        text += &line("tip", Some(list(&self.tip)));
        text + &line("identify", self.identify.then(|| "true".into()))
    }
}

impl SensorEntry {
    pub(crate) fn to_text(&self) -> String {
        let mut text = format!("\n[[sensor]]\ncovariate = {}\n", quoted(&self.covariate));
        text += &line("platform", self.platform.map(|v| list(&v)));
        text + &line("base", self.base.map(|v| list(&v)))
    }
}

impl EffectEntry {
    pub(crate) fn to_text(&self) -> String {
        let single = |v: &f64| number(*v);
        let mut text = format!("\n[[effect]]\nname = {}\n", quoted(&self.name));
        text += &line("leg", self.leg.map(|leg| leg.to_string()));
        text += &line("row", self.row.map(|row| row.to_string()));
        text += &line("of", self.of.as_ref().map(|of| quoted(of)));
        text += &line("lag_s", self.lag_s.as_ref().map(single));
        text += &line("parameters", Some(inline(&self.parameters, single)));
        let stated = |text: String, any: bool| any.then_some(text);
        text += &line("sigma", stated(inline(&self.sigma, single), !self.sigma.is_empty()));
        text += &line("range", stated(inline(&self.range, |v| list(v)), !self.range.is_empty()));
        text + &line("reference", stated(inline(&self.reference, single), !self.reference.is_empty()))
    }
}

impl OffsetSection {
    pub(crate) fn to_text(&self) -> String {
        format!("\n[offset]\nposition = {}\nrotation = {}\n", list(&self.position), list(&self.rotation))
    }
}

/// A table on one line.
fn inline<V>(table: &BTreeMap<String, V>, shown: impl Fn(&V) -> String) -> String {
    let entries: Vec<String> =
        table.iter().map(|(key, value)| format!("{} = {}", quoted_key(key), shown(value))).collect();
    if entries.is_empty() { "{}".into() } else { format!("{{ {} }}", entries.join(", ")) }
}

/// A key, quoted where it must be.
fn quoted_key(key: &str) -> String {
    let bare = !key.is_empty() && key.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'-'));
    if bare { key.into() } else { quoted(key) }
}
