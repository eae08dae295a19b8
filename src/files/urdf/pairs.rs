//! Closures that are stated by pairs of names: closing frames, side files, and the call.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::closures::{Closure, End, Frame, Motion, Source};
use super::description::Description;
use super::findings::{Findings, did_you_mean};
use crate::files::finding::FindingKind as K;

/// A pair of frames that coincide when the mechanism is assembled, by the names of links or joints.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Pair {
    pub(super) names: [String; 2],
    pub(super) motion: Motion,
    pub(super) source: Source,
}

impl Pair {
    /// The closure of a pair. The frame of a joint is that of its child.
    pub(super) fn closure(&self, robot: &Description, findings: &mut Findings) -> Option<Closure> {
        let mut end = |name: &String| {
            let link = robot.links.iter().find(|l| l.name == *name).map(|l| l.name.clone());
            let link = link.or_else(|| robot.joints.iter().find(|j| j.name == *name).map(|j| j.child.clone()));
            if link.is_none() {
                let names = robot.links.iter().map(|l| &l.name).chain(robot.joints.iter().map(|j| &j.name));
                let hint = did_you_mean(name, names.map(String::as_str));
                let text = format!("{} names '{name}', which is neither a link nor a joint{hint}", self.source);
                findings.add(K::UnknownClosureLink, name, None, text);
            }
            Some(End { link: link?, frame: Some(Frame::identity()) })
        };
        let (a, b) = (end(&self.names[0]), end(&self.names[1]));
        let name = self.names.join(" = ");
        Some(Closure { name, line: None, source: self.source, motion: self.motion, ends: [a?, b?] })
    }
}

/// The ends of a closing frame as they are found: first, second, and the twins along z that mark a hinge.
#[derive(Default)]
struct Frames<'a> {
    ends: [Option<(&'a str, usize)>; 2],
    twins: [bool; 2],
}

/// Pairs of links `closing_<name>_1` and `closing_<name>_2`.
pub(super) fn closing_frames(robot: &Description, findings: &mut Findings) -> Vec<Closure> {
    let mut found: BTreeMap<&str, Frames<'_>> = BTreeMap::new();
    let mut order = Vec::new();
    for link in &robot.links {
        let Some(rest) = link.name.strip_prefix("closing_") else { continue };
        let (rest, twin) = rest.strip_suffix("_z").map_or((rest, false), |r| (r, true));
        let Some((name, end)) = rest.rsplit_once('_') else { continue };
        let Some(end) = ["1", "2"].iter().position(|e| *e == end) else { continue };
        if !found.contains_key(name) {
            order.push(name);
        }
        let frames = found.entry(name).or_default();
        if twin {
            frames.twins[end] = true;
        } else {
            frames.ends[end] = Some((&link.name, link.line));
        }
    }
    let mut closures = Vec::new();
    for name in order {
        let Some(frames) = found.get(name) else { continue };
        match frames.ends {
            [Some((a, line)), Some((b, _))] => {
                let motion = if frames.twins == [true; 2] { Motion::Hinge(Vector3::z()) } else { Motion::Undecided };
                let end = |link: &str| End { link: link.into(), frame: Some(Frame::identity()) };
                closures.push(Closure {
                    name: format!("closing_{name}"),
                    line: Some(line),
                    source: Source::ClosingFrames,
                    motion,
                    ends: [end(a), end(b)],
                });
            }
            [Some((link, line)), None] | [None, Some((link, line))] => {
                let other = if frames.ends[0].is_some() { 2 } else { 1 };
                let text = format!(
                    "link '{link}' has no partner 'closing_{name}_{other}'; add the frame on the other body, or rename \
                     the link if it closes nothing"
                );
                findings.add(K::UnpairedClosingFrame, link, line, text);
            }
            [None, None] => {}
        }
    }
    closures
}
