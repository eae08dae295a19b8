//! Sections of a mechanism file about what acts on the mechanism: sensors, effects, and offsets in pose space.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::effect::{ScanPoint, label};
use crate::files::mechanism::document::{line, list, quoted};
use crate::files::table::writer::number;

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

impl SensorEntry {
    pub(crate) fn to_text(&self) -> String {
        let mut text = format!("\n[[sensor]]\ncovariate = {}\n", quoted(&self.covariate));
        text += &line("platform", self.platform.map(|v| list(&v)));
        text + &line("base", self.base.map(|v| list(&v)))
    }
}

impl EffectEntry {
    /// Display name, such as `drift.leg[leg=3]`.
    pub fn label(&self) -> String {
        let at = ScanPoint { leg: self.leg.map(|leg| leg.wrapping_sub(1)), row: self.row, covariate: self.of.clone() };
        label(&self.name, &at)
    }

    pub(crate) fn to_text(&self) -> String {
        let single = |v: &f64| number(*v);
        let mut text = format!("\n[[effect]]\nname = {}\n", quoted(&self.name));
        text += &line("leg", self.leg.map(|leg| leg.to_string()));
        text += &line("row", self.row.map(|row| row.to_string()));
        text += &line("of", self.of.as_ref().map(|of| quoted(of)));
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
