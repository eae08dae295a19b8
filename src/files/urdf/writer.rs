//! A mechanism as URDF, with closing frames, and the side file for what URDF cannot say.
//!
//! Each leg is `base -> u1 -> u2 -> slide -> closing_<leg>_1`, with its partner `closing_<leg>_2` on the platform. The
//! two revolutes meet in `b`, the closing frames stand at the true length and at `a`, so what is read back are these
//! numbers and not sums of others. The platform is a child of the base by a `floating` joint at the home pose.

use std::collections::HashSet;

use nalgebra::{Rotation3, Vector3};

use super::description::escaped;
use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::kinds::six_hardpoint::KIND;
use crate::files::table::writer::number;
use crate::mechanism::{Leg, SixHardpoint};
use crate::pose::Pose;

/// A mechanism as URDF.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct UrdfFiles {
    /// Text of the URDF.
    pub robot: String,
    /// Text of the TOML beside it, of the same stem.
    pub side: String,
    /// True if the side file states more than name and units.
    pub side_needed: bool,
    /// Properties that could not be kept, and what was chosen instead.
    pub warnings: Vec<String>,
}

/// Half of the travel of a slide whose leg states none, as a part of its length.
const DEFAULT_TRAVEL: f64 = 0.5;

impl Machine {
    /// The mechanism as URDF with a side file.
    ///
    /// # Errors
    /// [`FileError::Value`] for a mechanism of another kind than six legs.
    pub fn to_urdf(&self) -> Result<UrdfFiles, FileError> {
        let mechanism: &dyn std::any::Any = self.plain();
        let Some(legs) = mechanism.downcast_ref::<SixHardpoint>().map(SixHardpoint::to_legs) else {
            return Err(FileError::Value {
                path: self.path.clone(),
                place: "type".into(),
                problem: format!("only a mechanism of kind '{}' can be written as URDF; write .toml", KIND.name),
            });
        };
        let home = self.mechanism.home();
        let mut warnings = Vec::new();
        let mut side =
            MechanismDocument { legs: Vec::new(), home: None, nominal_home: None, ..self.document().clone() };
        let plain = MechanismDocument {
            workspace: None,
            tolerance: None,
            noise: None,
            platform: None,
            actuator: None,
            plane: None,
            gravity_axis: None,
            reference_temperature: None,
            shared_anchors: false,
            rotation_order: Default::default(),
            pivot: [0.0; 3],
            targets: Vec::new(),
            effects: Vec::new(),
            sensors: Vec::new(),
            ..side.clone()
        };
        if !at_rest(&legs, &home) {
            side.home = Some(self.units().home(&self.convention, &home));
        }
        let extra = self.extra_keys(&legs, &mut warnings);
        if self.nominal.is_some() {
            warnings.push(
                "the nominal geometry of this calibrated file cannot be kept in URDF: commanded poses (cmd_x …) would \
                 be converted to lengths with the calibrated one; keep the TOML for such data"
                    .into(),
            );
        }
        let names: Vec<Option<String>> = self.document().legs.iter().map(|l| l.joint.clone()).collect();
        let reversed: Vec<bool> = self.document().legs.iter().map(|l| l.joint_reversed).collect();
        let side_needed = !extra.is_empty() || side.to_text() != plain.to_text();
        Ok(UrdfFiles {
            robot: robot(&self.document().name, &legs, &home, &names, &reversed),
            side: extra + &side.to_text(),
            side_needed,
            warnings,
        })
    }

    /// Offsets, and ranges where a leg states none, in the unit of the file.
    fn extra_keys(&self, legs: &[Leg], warnings: &mut Vec<String>) -> String {
        let shown = |v: f64| number(self.length_unit.from_si(v));
        let mut text = String::new();
        if legs.iter().any(|l| l.length_offset != 0.0) {
            let list: Vec<String> = legs.iter().map(|l| shown(l.length_offset)).collect();
            text += &format!("length_offsets = [{}]\n", list.join(", "));
        }
        let without: Vec<String> =
            (1..).zip(legs).filter(|(_, l)| l.stroke.is_none()).map(|(k, _)| k.to_string()).collect();
        if !without.is_empty() {
            let list =
                legs.iter().map(|l| l.stroke.map_or("[]".into(), |[a, b]| format!("[{}, {}]", shown(a), shown(b))));
            text += &format!("strokes = [{}]\n", list.collect::<Vec<_>>().join(", "));
            let which = match without.len() {
                6 => "no leg states a stroke".into(),
                1 => format!("leg {} states no stroke", without[0]),
                _ => format!("legs {} state no stroke", without.join(", ")),
            };
            warnings.push(format!(
                "{which}; URDF needs limits, so half of the length either way is written, and `strokes` in the side \
                 file says that there are none"
            ));
        }
        text
    }
}

/// True if the lengths at rest and the angles of a frame bring back this home.
fn at_rest(legs: &[Leg], home: &Pose) -> bool {
    let length = |l: &Leg| l.length + l.length_offset;
    let mean = legs.iter().map(length).sum::<f64>() / legs.len() as f64;
    let gap = |l: &Leg| ((home.place(&l.platform) - l.base).norm() - length(l)).abs();
    let q = home.coordinates();
    let turned = Rotation3::from_euler_angles(q[3], q[4], q[5]);
    legs.iter().all(|l| gap(l) < 0.5e-4 * mean) && (turned.matrix() - home.rotation.matrix()).norm() < 1e-14
}

/// Writes elements, one a line.
struct Xml {
    text: String,
    joints: HashSet<String>,
}

impl Xml {
    fn line(&mut self, line: &str) {
        self.text += line;
        self.text.push('\n');
    }

    /// A name of a joint that no other joint has.
    fn free(&mut self, name: &str) -> String {
        let mut name = name.to_owned();
        while !self.joints.insert(name.clone()) {
            name.push('_');
        }
        name
    }

    fn link(&mut self, name: &str, visuals: &[String]) {
        if visuals.is_empty() {
            return self.line(&format!("  <link name=\"{name}\"/>"));
        }
        self.line(&format!("  <link name=\"{name}\">"));
        visuals.iter().for_each(|v| self.line(&format!("    <visual>{v}</visual>")));
        self.line("  </link>");
    }

    fn joint(&mut self, name: &str, kind: &str, [parent, child]: [&str; 2], origin: &str, more: &str) {
        self.line(&format!(
            "  <joint name=\"{}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>{origin}{more}</joint>",
            escaped(name)
        ));
    }
}

fn origin(p: &Vector3<f64>, rpy: [f64; 3]) -> String {
    let list = |v: [f64; 3]| v.map(number).join(" ");
    format!("<origin xyz=\"{}\" rpy=\"{}\"/>", list([p.x, p.y, p.z]), list(rpy))
}

/// Angles of a frame whose z axis has this direction.
fn along(u: &Vector3<f64>) -> [f64; 3] {
    [(-u.y).clamp(-1.0, 1.0).asin(), u.x.atan2(u.z), 0.0]
}

fn cylinder(from: f64, to: f64, radius: f64, material: &str) -> String {
    format!(
        "{}<geometry><cylinder radius=\"{}\" length=\"{}\"/></geometry><material name=\"{material}\"/>",
        origin(&Vector3::new(0.0, 0.0, 0.5 * (from + to)), [0.0; 3]),
        number(radius),
        number(to - from)
    )
}

fn sphere(at: &Vector3<f64>, radius: f64, material: &str) -> String {
    let geometry = format!("<geometry><sphere radius=\"{}\"/></geometry>", number(radius));
    format!("{}{geometry}<material name=\"{material}\"/>", origin(at, [0.0; 3]))
}

/// Anchors as balls, and struts from each to the next.
fn frame_of(points: &[Vector3<f64>], radius: f64, material: &str) -> Vec<String> {
    let mut visuals: Vec<String> = points.iter().map(|p| sphere(p, 1.5 * radius, material)).collect();
    for (k, from) in points.iter().enumerate() {
        let step = points[(k + 1) % points.len()] - from;
        let length = step.norm();
        if length > radius {
            let rod = format!("<cylinder radius=\"{}\" length=\"{}\"/>", number(0.5 * radius), number(length));
            let place = origin(&(from + 0.5 * step), along(&(step / length)));
            visuals.push(format!("{place}<geometry>{rod}</geometry><material name=\"{material}\"/>"));
        }
    }
    visuals
}

fn robot(name: &str, legs: &[Leg], home: &Pose, names: &[Option<String>], reversed: &[bool]) -> String {
    let radius = 0.02 * legs.iter().map(|l| l.length).sum::<f64>() / legs.len() as f64;
    let mut xml = Xml { text: String::new(), joints: names.iter().flatten().cloned().collect() };
    xml.line("<?xml version=\"1.0\"?>");
    xml.line(
        "<!-- Frames closing_legN_1 and closing_legN_2 coincide when the mechanism is assembled. Joint coordinates are 0 at\n     \
         the home lengths. Efforts, velocities, angle limits and shapes are placeholders. -->",
    );
    xml.line(&format!("<robot name=\"{}\">", escaped(name)));
    for (material, rgba) in [("base", "0.4 0.4 0.45 1"), ("platform", "0.2 0.4 0.7 1"), ("leg", "0.75 0.75 0.78 1")] {
        xml.line(&format!("  <material name=\"{material}\"><color rgba=\"{rgba}\"/></material>"));
    }
    let points = |of: fn(&Leg) -> Vector3<f64>| legs.iter().map(of).collect::<Vec<_>>();
    xml.link("base", &frame_of(&points(|l| l.base), radius, "base"));
    xml.link("platform", &frame_of(&points(|l| l.platform), radius, "platform"));
    let q = home.coordinates();
    let free = xml.free("platform_free");
    xml.joint(&free, "floating", ["base", "platform"], &origin(&home.position, [q[3], q[4], q[5]]), "");
    let zero = origin(&Vector3::zeros(), [0.0; 3]);
    for (k, l) in legs.iter().enumerate() {
        let n = format!("leg{}", k + 1);
        let length = l.length + l.length_offset;
        let reach = home.place(&l.platform) - l.base;
        let u = reach.try_normalize(0.0).unwrap_or_else(Vector3::z);
        let [cross, tube, rod] = ["cross", "cylinder", "rod"].map(|part| format!("{n}_{part}"));
        let [tip, anchor] = [1, 2].map(|end| format!("closing_{n}_{end}"));
        xml.link(&cross, &[]);
        xml.link(&tube, &[cylinder(0.0, 0.6 * length, radius, "leg")]);
        xml.link(&rod, &[cylinder(0.4 * length, length, 0.6 * radius, "platform")]);
        xml.link(&tip, &[]);
        xml.link(&anchor, &[]);
        let turns = "<limit lower=\"-1.57\" upper=\"1.57\" effort=\"1000\" velocity=\"1\"/>";
        let (u1, u2) = (xml.free(&format!("{n}_u1")), xml.free(&format!("{n}_u2")));
        let x = format!("<axis xyz=\"1 0 0\"/>{turns}");
        xml.joint(&u1, "revolute", ["base", &cross], &origin(&l.base, along(&u)), &x);
        xml.joint(&u2, "revolute", [&cross, &tube], &zero, &format!("<axis xyz=\"0 1 0\"/>{turns}"));
        let slide = names.get(k).cloned().flatten().unwrap_or_else(|| xml.free(&format!("{n}_slide")));
        let [from, to] =
            l.stroke.map_or([-DEFAULT_TRAVEL * l.length, DEFAULT_TRAVEL * l.length], |s| s.map(|v| v - l.length));
        let reversed = reversed.get(k).copied().unwrap_or_default();
        let (axis, [lower, upper]) = if reversed { ("0 0 -1", [-to, -from]) } else { ("0 0 1", [from, to]) };
        let more = format!(
            "<axis xyz=\"{axis}\"/><limit lower=\"{}\" upper=\"{}\" effort=\"1000\" velocity=\"1\"/>",
            number(lower),
            number(upper)
        );
        xml.joint(&slide, "prismatic", [&tube, &rod], &zero, &more);
        let (first, second) = (xml.free(&format!("{tip}_frame")), xml.free(&format!("{anchor}_frame")));
        let at_tip = origin(&Vector3::new(0.0, 0.0, length), [0.0; 3]);
        xml.joint(&first, "fixed", [&rod, &tip], &at_tip, "");
        xml.joint(&second, "fixed", ["platform", &anchor], &origin(&l.platform, [0.0; 3]), "");
    }
    xml.line("</robot>");
    xml.text
}
