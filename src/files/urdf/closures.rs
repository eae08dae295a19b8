//! Closures as the tags of different tools state them.
//!
//! | tag | points | written and read by |
//! |---|---|---|
//! | `<loop_joint>` with `<link1>`, `<link2>` | poses in both links | Isaac Sim |
//! | `<drake:ball_constraint>` | points in both bodies | Drake |
//! | `<loop>` with `<predecessor>`, `<successor>` | poses in both links | URDF+ |
//! | `<constraint>` with `<parent>`, `<child>` and origins | poses in both links | a proposal for urdfdom |
//! | `<gazebo><joint>` | a pose in the child; its place in the parent is where the child stands at home | Gazebo Classic |
//!
//! All of them, closing frames and pairs become one record, a [`Closure`].

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::attributes::{Turn, known_attributes, number_list, numbers, origin};
use super::findings::Findings;
use super::xml::Element;
use crate::files::finding::FindingKind as K;

/// Pose of one frame in another.
pub(super) type Frame = Isometry3<f64>;

/// Where a closure is stated. If two close the same bodies they must agree, and the later in this list is reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Source {
    Option,
    SideFile,
    Tag(&'static str),
    ClosingFrames,
    Joint,
}

impl std::fmt::Display for Source {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Option => write!(f, "a pair of the command line"),
            Self::SideFile => write!(f, "a pair of the side file"),
            Self::Tag(tag) => write!(f, "<{tag}>"),
            Self::ClosingFrames => write!(f, "closing frames"),
            Self::Joint => write!(f, "a joint"),
        }
    }
}

/// Freedoms of a joint or closure. Axes are in the first of its two frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Motion {
    Fixed,
    Hinge(Vector3<f64>),
    Slide(Vector3<f64>),
    /// A common point with so many free turns.
    Point(usize),
    /// Frames that coincide when the loop is closed; what they leave free is not stated.
    Undecided,
    /// Everything.
    Floating,
    Planar,
}

/// One end of a closure: a link by name, and the closing frame in it.
#[derive(Clone, Debug)]
pub(super) struct End {
    pub(super) link: String,
    /// `None` where the frame is to be taken from the other link at home.
    pub(super) frame: Option<Frame>,
}

/// A closure before its links are looked up.
#[derive(Clone, Debug)]
pub(super) struct Closure {
    pub(super) name: String,
    pub(super) line: Option<usize>,
    pub(super) source: Source,
    pub(super) motion: Motion,
    pub(super) ends: [End; 2],
}

/// The closures of all tags below the root.
pub(super) fn inline(root: &Element, findings: &mut Findings) -> Vec<Closure> {
    let mut found = Vec::new();
    for element in &root.children {
        let local = element.name.rsplit(':').next().unwrap_or_default();
        let before = found.len();
        match local {
            "loop_joint" => found.extend(loop_joint(element, findings)),
            "ball_constraint" => found.extend(ball_constraint(element, findings)),
            "loop" => found.extend(urdf_plus(element, findings)),
            "constraint" => found.extend(constraint(element, findings)),
            "gazebo" => {
                for joint in element.children_named("joint") {
                    found.extend(gazebo(joint, findings));
                }
            }
            _ => {}
        }
        for (closure, k) in found[before..].iter_mut().zip(before + 1..) {
            if closure.name.is_empty() {
                closure.name = format!("closure {k}");
            }
        }
    }
    found
}

/// A frame of position and orientation.
pub(super) fn frame(xyz: [f64; 3], turn: Turn) -> Frame {
    let rotation = match turn {
        Turn::Rpy([r, p, y]) => UnitQuaternion::from_euler_angles(r, p, y),
        Turn::Quaternion([x, y, z, w]) => UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
    };
    Frame::from_parts(Translation3::from(Vector3::from(xyz)), rotation)
}

/// Freedoms of a type of closure; `None` if the type is unknown.
fn motion(kind: &str, axis: Option<[f64; 3]>) -> Option<Motion> {
    let axis = Vector3::from(axis.unwrap_or([1.0, 0.0, 0.0])).normalize();
    Some(match kind {
        "spherical" | "ball" | "point" => Motion::Point(3),
        "universal" => Motion::Point(2),
        "revolute" | "continuous" | "hinge" => Motion::Hinge(axis),
        "prismatic" => Motion::Slide(axis),
        "fixed" | "weld" => Motion::Fixed,
        "planar" => Motion::Planar,
        "floating" => Motion::Floating,
        _ => return None,
    })
}

/// Name, type, axis and ends of a tag, put together.
struct Parts<'a> {
    tag: &'static str,
    element: &'a Element,
    kind: Option<&'a str>,
    axis: Option<&'a Element>,
    ends: [Option<End>; 2],
}

impl Parts<'_> {
    fn closure(self, findings: &mut Findings) -> Option<Closure> {
        let name = self.element.attribute("name").unwrap_or_default().trim().to_owned();
        let (line, tag) = (self.element.line, self.tag);
        let what = format!("<{tag}> '{name}'");
        let [Some(a), Some(b)] = self.ends else {
            findings.add(K::MissingPart, name, line, format!("{what} does not name both of its links; complete it"));
            return None;
        };
        // Gazebo writes the numbers of an axis into an element of their own.
        let axis = self.axis.and_then(|a| match a.child("xyz") {
            Some(xyz) => number_list(&xyz.text, xyz.line, &format!("{what} axis"), findings),
            None => {
                known_attributes(a, &["xyz"], &format!("{what} axis"), findings);
                numbers(a, "xyz", &format!("{what} axis"), findings).flatten()
            }
        });
        if axis.is_some_and(|a: [f64; 3]| a.iter().all(|v| v.abs() < 1e-100)) {
            findings.add(K::ZeroAxis, name, line, format!("{what} has an axis of length zero; state its direction"));
            return None;
        }
        let kind = self.kind.map_or("", str::trim);
        let Some(motion) = motion(kind, axis) else {
            let known = "spherical, universal, revolute, continuous, prismatic, fixed";
            let text = format!("{what} is of type '{kind}'; the supported types are {known}");
            findings.add(K::UnknownClosureType, name, line, text);
            return None;
        };
        if axis.is_none() && matches!(motion, Motion::Hinge(_) | Motion::Slide(_)) {
            let text = format!("{what} states no direction of its axis; x is assumed, so state <axis xyz=\"…\"/>");
            findings.add(K::DefaultAxis, &name, line, text);
        }
        Some(Closure { name, line: Some(line), source: Source::Tag(tag), motion, ends: [a, b] })
    }
}

/// An end whose link and pose stand in attributes of two elements.
fn end(link: Option<&str>, pose: Option<&Element>, what: &str, findings: &mut Findings) -> Option<End> {
    let link = link?.trim().to_owned();
    let (xyz, turn) = match pose {
        None => ([0.0; 3], Turn::Rpy([0.0; 3])),
        // A wrong number is reported; the run stops before this frame is used.
        Some(_) => origin(pose, what, findings).unwrap_or(([0.0; 3], Turn::Rpy([0.0; 3]))),
    };
    Some(End { link, frame: Some(frame(xyz, turn)) })
}

fn loop_joint(element: &Element, findings: &mut Findings) -> Option<Closure> {
    let mut at = |name: &str| {
        let link = element.child(name)?;
        end(link.attribute("link"), Some(link), "<loop_joint>", findings)
    };
    let ends = [at("link1"), at("link2")];
    let (kind, axis) = (element.attribute("type"), element.child("axis"));
    Parts { tag: "loop_joint", element, kind, axis, ends }.closure(findings)
}

fn ball_constraint(element: &Element, findings: &mut Findings) -> Option<Closure> {
    let part = |suffix: &str| element.children.iter().find(|c| c.name.ends_with(suffix));
    let mut at = |body: &str, point: &str| {
        let link = part(body)?.attribute("name")?.trim().to_owned();
        let value = part(point).and_then(|p| Some((p.attribute("value")?, p.line)));
        let what = format!("<drake:ball_constraint> of '{link}', point");
        let xyz = value.map_or(Some([0.0; 3]), |(text, line)| number_list(text, line, &what, findings));
        Some(End { link, frame: Some(frame(xyz.unwrap_or_default(), Turn::Rpy([0.0; 3]))) })
    };
    let ends =
        [at("ball_constraint_body_A", "ball_constraint_p_AP"), at("ball_constraint_body_B", "ball_constraint_p_BQ")];
    Parts { tag: "drake:ball_constraint", element, kind: Some("ball"), axis: None, ends }.closure(findings)
}

fn urdf_plus(element: &Element, findings: &mut Findings) -> Option<Closure> {
    let mut at = |name: &str| {
        let link = element.child(name)?;
        end(link.attribute("link"), link.child("origin"), "<loop>", findings)
    };
    let ends = [at("predecessor"), at("successor")];
    Parts { tag: "loop", element, kind: element.attribute("type"), axis: element.child("axis"), ends }.closure(findings)
}

fn constraint(element: &Element, findings: &mut Findings) -> Option<Closure> {
    let mut at = |name: &str, pose: &str| {
        let link = element.child(name)?.attribute("link");
        end(link, element.child(pose), "<constraint>", findings)
    };
    let ends = [at("parent", "parent_origin"), at("child", "child_origin")];
    let (kind, axis) = (element.attribute("type"), element.child("parent_axis"));
    Parts { tag: "constraint", element, kind, axis, ends }.closure(findings)
}

fn gazebo(element: &Element, findings: &mut Findings) -> Option<Closure> {
    let link = |name: &str| element.child(name).map(|l| l.text.trim().to_owned()).filter(|l| !l.is_empty());
    let pose = element.child("pose").filter(|p| !p.text.trim().is_empty());
    let six = pose.and_then(|p| number_list::<6>(&p.text, p.line, "<gazebo><joint> pose", findings));
    let [x, y, z, r, p, w] = six.unwrap_or_default();
    let child = link("child").map(|link| End { link, frame: Some(frame([x, y, z], Turn::Rpy([r, p, w]))) });
    let parent = link("parent").map(|link| End { link, frame: None });
    let (kind, axis) = (element.attribute("type"), element.child("axis"));
    // The pose is given in the child and the axis in the frame of that pose, as SDF has it since 1.5, so the child comes
    // first. The place in the parent is taken at home when the links are known.
    Parts { tag: "gazebo", element, kind, axis, ends: [child, parent] }.closure(findings)
}
