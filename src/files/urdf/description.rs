//! The first pass: what of the XML matters here, with line numbers, and a reduced URDF for `urdf-rs`.
//!
//! `urdf-rs` reads joints and links, but stops at details of visuals and inertias that play no part here, keeps no
//! line numbers and passes over every tag that closes a loop. So this pass keeps names, frames, axes and slide
//! limits, checks every number, collects the closures, and hands the rest to `urdf-rs` in the form it accepts.

use super::attributes::{Turn, known_attributes, limits, numbers, origin};
use super::closures::{Closure, inline};
use super::findings::Findings;
use super::xml::Element;
use crate::files::finding::FindingKind as K;

/// Most links, and most joints.
const MAX_PARTS: usize = 5_000;

/// A link as it is named.
#[derive(Clone, Debug)]
pub(super) struct LinkNote {
    pub(super) name: String,
    pub(super) line: usize,
}

/// A joint as it is written, in numbers.
#[derive(Clone, Debug)]
pub(super) struct JointNote {
    pub(super) name: String,
    pub(super) line: usize,
    pub(super) kind: String,
    pub(super) parent: String,
    pub(super) child: String,
    pub(super) xyz: [f64; 3],
    pub(super) turn: Turn,
    /// Axis, if one is stated.
    pub(super) axis: Option<[f64; 3]>,
    /// Lower and upper limit of a slide, if stated.
    pub(super) limit: Option<[f64; 2]>,
    pub(super) mimic: Option<String>,
}

/// A file after the first pass.
#[derive(Debug, Default)]
pub(super) struct Description {
    pub(super) name: String,
    version: Option<String>,
    pub(super) links: Vec<LinkNote>,
    pub(super) joints: Vec<JointNote>,
    pub(super) closures: Vec<Closure>,
}

/// Types of joints that `urdf-rs` knows; `ball` is written for `spherical` by some.
const TYPES: [&str; 8] = ["revolute", "continuous", "prismatic", "fixed", "floating", "planar", "spherical", "ball"];

impl Description {
    /// Reads the tree of a file.
    pub(super) fn of(root: &Element, findings: &mut Findings) -> Self {
        if root.name != "robot" {
            let hint = match root.name.as_str() {
                "sdf" | "mujoco" | "model" | "Robot" | "COLLADA" | "openrave" => "convert it to URDF",
                _ => "give a URDF file",
            };
            let text = format!("root element is <{}> and not <robot>; {hint}, or write a mechanism file", root.name);
            findings.add(K::NotUrdf, "", root.line, text);
            return Self::default();
        }
        if let Some((line, what)) = unexpanded(root) {
            let text = format!("'{what}' is a macro of xacro; expand the file first: `xacro in.xacro > out.urdf`");
            findings.add(K::UnexpandedXacro, "", line, text);
            return Self::default();
        }
        let mut description = Self {
            name: root.attribute("name").unwrap_or_default().trim().to_owned(),
            version: root.attribute("version").map(str::to_owned),
            ..Self::default()
        };
        for (what, parts) in [("links", "link"), ("joints", "joint")] {
            let count = root.children_named(parts).count();
            if count > MAX_PARTS {
                let text =
                    format!("{count} {what}; at most {MAX_PARTS} are read, delete what is not part of the mechanism");
                findings.add(K::TooLarge, "", root.line, text);
                return description;
            }
        }
        description.read_links(root, findings);
        for element in root.children_named("joint") {
            description.read_joint(element, findings);
        }
        description.closures = inline(root, findings);
        let quaternions = description.joints.iter().find(|j| matches!(j.turn, Turn::Quaternion(_)));
        if let Some(joint) = quaternions.filter(|_| !description.version.as_deref().is_some_and(knows_quaternions)) {
            let text = "quat_xyzw is used, though readers of URDF 1.0 ignore it; state version=\"1.1\" in <robot>";
            findings.add(K::Note, &joint.name, joint.line, text);
        }
        description
    }

    fn read_links(&mut self, root: &Element, findings: &mut Findings) {
        let mut seen = std::collections::HashMap::new();
        for element in root.children_named("link") {
            let Some(name) = name_of(element, "link", findings) else { continue };
            if let Some(first) = seen.insert(name.clone(), element.line) {
                let text = format!("link '{name}' is already on line {first}; rename or delete one of them");
                findings.add(K::DuplicateLink, name, element.line, text);
                continue;
            }
            self.links.push(LinkNote { name, line: element.line });
        }
    }

    fn read_joint(&mut self, element: &Element, findings: &mut Findings) {
        let line = element.line;
        let Some(name) = name_of(element, "joint", findings) else { return };
        if let Some(first) = self.joints.iter().find(|j| j.name == name) {
            let text = format!("joint '{name}' is already on line {}; rename or delete one of them", first.line);
            findings.add(K::DuplicateJoint, name, line, text);
            return;
        }
        let what = format!("joint '{name}'");
        for part in ["origin", "parent", "child", "axis", "limit"] {
            if element.children_named(part).count() > 1 {
                findings.add(K::MissingPart, &name, line, format!("{what} has more than one <{part}>; keep one"));
                return;
            }
        }
        let link = |part: &str| element.child(part).and_then(|p| p.attribute("link")).map(|l| l.trim().to_owned());
        let (Some(kind), Some(parent), Some(child)) =
            (element.attribute("type").map(str::trim), link("parent"), link("child"))
        else {
            let text = format!("{what} lacks its type, <parent link> or <child link>; complete it");
            findings.add(K::MissingPart, &name, line, text);
            return;
        };
        if !TYPES.contains(&kind) {
            let advice = "URDF has fixed, revolute, continuous, prismatic, spherical, floating and planar; a universal \
                          joint is written as two revolutes";
            findings.add(K::UnsupportedJointType, &name, line, format!("{what} is of type '{kind}'; {advice}"));
            return;
        }
        let (xyz, turn) = origin(element.child("origin"), &what, findings).unwrap_or(([0.0; 3], Turn::Rpy([0.0; 3])));
        let axis = element.child("axis").map(|a| {
            known_attributes(a, &["xyz"], &format!("{what} axis"), findings);
            if a.attribute("xyz").is_none() && matches!(kind, "revolute" | "continuous" | "prismatic") {
                let text = format!("{what} has an <axis> without xyz; x is assumed, so state xyz=\"…\"");
                findings.add(K::DefaultAxis, &name, a.line, text);
            }
            numbers(a, "xyz", &format!("{what} axis"), findings)
        });
        let mut axis = axis.map(|a| a.flatten().unwrap_or([1.0, 0.0, 0.0]));
        let moves = matches!(kind, "revolute" | "continuous" | "prismatic");
        if let Some(a) = &mut axis
            && moves
        {
            // Scaled first: the squares of small or large numbers leave the range of numbers.
            let largest = a.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            if !(largest > 0.0) {
                let text = format!("{what} has an axis of length zero; state its direction, such as xyz=\"0 0 1\"");
                findings.add(K::ZeroAxis, &name, line, text);
            }
            *a = a.map(|v| v / largest);
        }
        if axis.is_none() && kind == "prismatic" {
            let text = format!("{what} has no <axis>; x is assumed, as URDF specifies");
            findings.add(K::DefaultAxis, &name, line, text);
        }
        let limit = element.child("limit").filter(|_| kind == "prismatic").and_then(|l| limits(l, &what, findings));
        let mimic = element.child("mimic").map(|m| m.attribute("joint").unwrap_or_default().trim().to_owned());
        let kind = if kind == "ball" { "spherical" } else { kind }.to_owned();
        self.joints.push(JointNote { name, line, kind, parent, child, xyz, turn, axis, limit, mimic });
    }

    /// The robot in the form that `urdf-rs` accepts.
    pub(super) fn reduced(&self) -> String {
        let list = |v: &[f64]| v.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(" ");
        let version = self.version.as_ref().map_or(String::new(), |v| format!(" version=\"{}\"", escaped(v)));
        let mut text = format!("<robot name=\"{}\"{version}>\n", escaped(&self.name));
        for link in &self.links {
            text += &format!("<link name=\"{}\"/>\n", escaped(&link.name));
        }
        for joint in &self.joints {
            let turn = match &joint.turn {
                Turn::Rpy(v) => format!("rpy=\"{}\"", list(v)),
                Turn::Quaternion(v) => format!("quat_xyzw=\"{}\"", list(v)),
            };
            text += &format!(
                "<joint name=\"{}\" type=\"{}\"><origin xyz=\"{}\" {turn}/><parent link=\"{}\"/><child link=\"{}\"/>",
                escaped(&joint.name),
                joint.kind,
                list(&joint.xyz),
                escaped(&joint.parent),
                escaped(&joint.child),
            );
            text += &joint.axis.map_or(String::new(), |a| format!("<axis xyz=\"{}\"/>", list(&a)));
            if let Some([lower, upper]) = joint.limit.filter(|[lower, upper]| lower <= upper) {
                text += &format!("<limit lower=\"{lower:?}\" upper=\"{upper:?}\" effort=\"0\" velocity=\"0\"/>");
            }
            text += "</joint>\n";
        }
        text + "</robot>\n"
    }
}

/// True for the versions of URDF that have `quat_xyzw`.
fn knows_quaternions(version: &str) -> bool {
    let numbers = version.trim().split_once('.').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    numbers.is_some_and(|v: (u32, u32)| v >= (1, 1))
}

/// Text as it stands in an attribute; control characters that XML does not have are spelled out (`\u{1b}`).
pub(in crate::files) fn escaped(text: &str) -> String {
    let is_none = |c: char| c.is_control() && !['\t', '\n', '\r'].contains(&c);
    let spelled = |c: char| if is_none(c) { c.escape_default().to_string() } else { c.to_string() };
    quick_xml::escape::escape(text.chars().map(spelled).collect::<String>()).into_owned()
}

/// The first macro of xacro in the tree, with its line.
fn unexpanded(element: &Element) -> Option<(usize, String)> {
    if element.name.starts_with("xacro:") {
        return Some((element.line, format!("<{}>", element.name)));
    }
    let texts = element.attributes.iter().map(|(_, v)| v).chain(std::iter::once(&element.text));
    let mut macros = texts.filter(|t| t.contains("${") || t.contains("$(arg ") || t.contains("$(find "));
    if let Some(text) = macros.next() {
        return Some((element.line, text.trim().chars().take(60).collect()));
    }
    element.children.iter().find_map(unexpanded)
}

fn name_of(element: &Element, what: &str, findings: &mut Findings) -> Option<String> {
    let name = element.attribute("name").map(str::trim).filter(|n| !n.is_empty());
    if name.is_none() {
        findings.add(K::MissingPart, "", element.line, format!("a <{what}> without a name; give it one"));
    }
    name.map(str::to_owned)
}
