//! The robot as links and edges, and where everything stands at home.

use std::collections::{HashMap, VecDeque};

use nalgebra::{Unit, UnitQuaternion, Vector3};
use urdf_rs::JointType;

use super::attributes::Turn;
use super::closures::{Closure, Frame, Motion, Source, frame};
use super::description::Description;
use super::findings::{Findings, did_you_mean};
use crate::files::finding::FindingKind as K;

/// One end of an edge: a link, and the frame of the edge in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub(super) link: usize,
    pub(super) frame: Frame,
}

/// A joint or a closure. At zero coordinates the frames of its sides coincide.
#[derive(Clone, Debug)]
pub(super) struct Edge {
    pub(super) name: String,
    pub(super) line: Option<usize>,
    pub(super) source: Source,
    pub(super) motion: Motion,
    /// Parent and child of a joint; the ends of a closure.
    pub(super) sides: [Side; 2],
    pub(super) limit: Option<[f64; 2]>,
    pub(super) mimic: Option<String>,
}

/// All links, and all joints and closures between them; the joints come first, in the order of the file.
#[derive(Debug)]
pub(super) struct Model {
    pub(super) links: Vec<String>,
    /// Lines of the links.
    pub(super) lines: Vec<usize>,
    pub(super) edges: Vec<Edge>,
    pub(super) joints: usize,
    /// Links that are nobody's child.
    pub(super) roots: Vec<usize>,
}

impl Model {
    /// The joints of a description, after `urdf-rs` has read it. `motions` are types that a side file gives to joints.
    pub(super) fn of(description: &Description, motions: &HashMap<String, Motion>, findings: &mut Findings) -> Self {
        let mut model = Self { links: Vec::new(), lines: Vec::new(), edges: Vec::new(), joints: 0, roots: Vec::new() };
        let robot = match urdf_rs::read_from_string(&description.reduced()) {
            Ok(robot) => robot,
            Err(cause) => {
                let text = format!("cannot be read as URDF: {cause}; correct the file or export it again");
                findings.add(K::Xml, "", None, text);
                return model;
            }
        };
        model.lines = description.links.iter().map(|l| l.line).collect();
        model.links = robot.links.iter().map(|l| l.name.clone()).collect();
        let index: HashMap<&str, usize> = model.links.iter().enumerate().map(|(k, n)| (n.as_str(), k)).collect();
        let mut edges = Vec::with_capacity(robot.joints.len());
        for (joint, note) in robot.joints.iter().zip(&description.joints) {
            let mut side = |link: &String, what: &str, frame: Frame| {
                let found = index.get(link.as_str()).copied();
                if found.is_none() {
                    let hint = did_you_mean(link, model.links.iter().map(String::as_str));
                    let text =
                        format!("joint '{}' has the {what} link '{link}', which does not exist{hint}", note.name);
                    findings.add(K::UnknownLink, &note.name, note.line, text);
                }
                Some(Side { link: found?, frame })
            };
            // urdf-rs turns quaternions into angles, which costs digits near a pitch of 90 degrees.
            let turn = match note.turn {
                Turn::Rpy(_) => Turn::Rpy(joint.origin.rpy.0),
                quaternion @ Turn::Quaternion(_) => quaternion,
            };
            let origin = frame(joint.origin.xyz.0, turn);
            let (parent, child) =
                (side(&joint.parent.link, "parent", origin), side(&joint.child.link, "child", Frame::identity()));
            let (Some(parent), Some(child)) = (parent, child) else { continue };
            let axis = Vector3::from(joint.axis.xyz.0).normalize();
            let motion = match joint.joint_type {
                JointType::Revolute | JointType::Continuous => Motion::Hinge(axis),
                JointType::Prismatic => Motion::Slide(axis),
                JointType::Fixed => Motion::Fixed,
                JointType::Floating => Motion::Floating,
                JointType::Planar => Motion::Planar,
                JointType::Spherical => Motion::Point(3),
            };
            edges.push(Edge {
                name: note.name.clone(),
                line: Some(note.line),
                source: Source::Joint,
                motion: motions.get(&note.name).copied().unwrap_or(motion),
                sides: [parent, child],
                limit: note.limit,
                mimic: note.mimic.clone(),
            });
        }
        let mut is_child = vec![false; model.links.len()];
        edges.iter().for_each(|e| is_child[e.sides[1].link] = true);
        model.roots = (0..is_child.len()).filter(|k| !is_child[*k]).collect();
        model.joints = edges.len();
        model.edges = edges;
        model
    }

    pub(super) fn link(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|l| l == name)
    }

    /// Adds a closure; a frame that is not stated stands where its partner is at home.
    pub(super) fn close(&mut self, closure: &Closure, home: &[Option<Frame>], findings: &mut Findings) {
        let mut links = [0; 2];
        for (k, end) in closure.ends.iter().enumerate() {
            let Some(link) = self.link(&end.link) else {
                let hint = did_you_mean(&end.link, self.links.iter().map(String::as_str));
                let text = format!(
                    "{} '{}' names link '{}', which does not exist{hint}",
                    closure.source, closure.name, end.link
                );
                findings.add(K::UnknownClosureLink, &closure.name, closure.line, text);
                return;
            };
            links[k] = link;
        }
        let stated = [closure.ends[0].frame, closure.ends[1].frame];
        let frames = match (stated, links.map(|l| home[l])) {
            ([Some(a), Some(b)], _) => [a, b],
            ([Some(_), None], _) if !self.hang_together(links) => {
                let [a, b] = closure.ends.each_ref().map(|e| &e.link);
                let text = format!(
                    "{} '{}' states its place in '{a}' only, and '{a}' and '{b}' hang from different roots, so nothing says \
                     where '{b}' is; join the platform with the base by a floating joint at its home pose",
                    closure.source, closure.name
                );
                findings.add(K::MissingPart, &closure.name, closure.line, text);
                return;
            }
            ([Some(a), None], [Some(of_a), Some(of_b)]) => [a, of_b.inverse() * of_a * a],
            _ => {
                let text =
                    format!("{} '{}' does not state where it is; give both places", closure.source, closure.name);
                findings.add(K::MissingPart, &closure.name, closure.line, text);
                return;
            }
        };
        self.edges.push(Edge {
            name: closure.name.clone(),
            line: closure.line,
            source: closure.source,
            motion: closure.motion,
            sides: [Side { link: links[0], frame: frames[0] }, Side { link: links[1], frame: frames[1] }],
            limit: None,
            mimic: None,
        });
    }

    /// True if two links hang from one root; of more than two roots, which are refused, it says nothing.
    fn hang_together(&self, links: [usize; 2]) -> bool {
        let [first, second] = self.roots[..] else { return true };
        let reached = [first, second].map(|root| {
            let mut seen = vec![false; self.links.len()];
            seen[root] = true;
            let mut grown = true;
            while grown {
                grown = false;
                for [parent, child] in self.edges[..self.joints].iter().map(|e| e.sides.map(|s| s.link)) {
                    if seen[parent] && !seen[child] {
                        seen[child] = true;
                        grown = true;
                    }
                }
            }
            links.map(|l| seen[l])
        });
        // A link that both reach stands where one of them puts it, and the other may not agree.
        reached == [[true; 2], [false; 2]] || reached == [[false; 2], [true; 2]]
    }

    /// Poses of the links when the joints stand at `values` (zero if absent), each root at the origin. A link with
    /// several parents stands where the first of them puts it. `None` for links that no root reaches.
    pub(super) fn places(&self, values: &HashMap<usize, f64>) -> Vec<Option<Frame>> {
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); self.links.len()];
        for (k, e) in self.edges[..self.joints].iter().enumerate() {
            children[e.sides[0].link].push(k);
        }
        let mut places = vec![None; self.links.len()];
        let mut queue: VecDeque<usize> = self.roots.iter().copied().collect();
        self.roots.iter().for_each(|r| places[*r] = Some(Frame::identity()));
        while let Some(link) = queue.pop_front() {
            let Some(place) = places[link] else { continue };
            for k in &children[link] {
                let edge = &self.edges[*k];
                let child = edge.sides[1].link;
                if places[child].is_none() {
                    let value = values.get(k).copied().unwrap_or(0.0);
                    places[child] = Some(place * edge.sides[0].frame * moved(edge.motion, value));
                    queue.push_back(child);
                }
            }
        }
        places
    }

    /// Reports links that no walk reaches, and more roots than `allowed`.
    pub(super) fn check_roots(&self, places: &[Option<Frame>], allowed: usize, findings: &mut Findings) {
        let names = |of: &[usize]| {
            let more = if of.len() > 6 { ", …" } else { "" };
            of.iter().take(6).map(|k| format!("'{}'", self.links[*k])).collect::<Vec<_>>().join(", ") + more
        };
        if self.roots.len() > allowed {
            let text = format!(
                "{} links have no parent: {}; join them to the base by joints. If there are two and one is the platform, \
                 name it with `--platform-link`",
                self.roots.len(),
                names(&self.roots)
            );
            findings.add(K::SeveralRoots, self.links[self.roots[0]].clone(), None, text);
        }
        let lost: Vec<usize> = (0..places.len()).filter(|k| places[*k].is_none()).collect();
        if !lost.is_empty() {
            let text = format!(
                "the links {} are children of one another and no root reaches them; correct <parent> and <child> of \
                 their joints",
                names(&lost)
            );
            findings.add(K::CyclicParents, self.links[lost[0]].clone(), None, text);
        }
    }
}

/// The motion of a joint at a coordinate.
fn moved(motion: Motion, value: f64) -> Frame {
    match motion {
        Motion::Hinge(axis) => {
            let turn = UnitQuaternion::from_axis_angle(&Unit::new_unchecked(axis), value);
            Frame::from_parts(nalgebra::Translation3::identity(), turn)
        }
        Motion::Slide(axis) => Frame::from_parts((axis * value).into(), UnitQuaternion::identity()),
        _ => Frame::identity(),
    }
}
