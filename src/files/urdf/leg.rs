//! The anchors and the length of one leg, from its joints alone.
//!
//! The leg is laid out from its slide: the frame of the slide at `q = 0` is the origin, and every joint is at its
//! zero. The axes of the passive joints of one end meet in the anchor, and a point on an axis stays where it is when
//! the joint turns, so neither the home pose nor the passive angles of the file matter. The slide moves one anchor
//! away from the other along their line, hence `length = L0 + q` or `L0 - q`.

use nalgebra::Vector3;

use super::anchor::{End, check_turns, common_point, decide, largest_miss};
use super::bodies::Bodies;
use super::closures::{Frame, Motion};
use super::graph::Part;
use super::model::Model;
use crate::files::finding::{Finding, FindingKind as K};

/// A leg in numbers.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    pub(super) joint: String,
    pub(super) line: Option<usize>,
    /// The coordinate of the joint.
    pub(super) edge: usize,
    /// True if the leg gets shorter as the coordinate grows.
    pub(super) reversed: bool,
    /// Anchors in the bodies of base and platform.
    pub(super) anchors: [Vector3<f64>; 2],
    /// The links of the leg that carry the anchors, and the anchors in them.
    pub(super) ends: [(usize, Vector3<f64>); 2],
    pub(super) length: f64,
}

/// Tolerances of the extraction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Allowed {
    /// m; 1e-4 of the leg if absent.
    pub(super) distance: Option<f64>,
}

impl Allowed {
    pub(super) fn distance(self, length: f64) -> f64 {
        self.distance.unwrap_or(1e-4 * length)
    }

    fn angle(self, length: f64) -> f64 {
        (self.distance(length) / length).max(1e-3)
    }
}

/// Measures a leg between two bodies.
pub(super) fn measure(
    model: &Model,
    bodies: &Bodies,
    leg: &Part,
    [base, platform]: [usize; 2],
    allowed: Allowed,
) -> Result<Measured, Finding> {
    let slide = leg.slides.first().copied().unwrap_or_default();
    let edge = &model.edges[slide];
    let finding = |kind, text: String| Finding { kind, element: edge.name.clone(), line: edge.line, text };
    let Motion::Slide(axis) = edge.motion else {
        return Err(finding(K::LegWithoutSlide, format!("joint '{}' is not a slide", edge.name)));
    };
    let walk = |side: usize, target: usize, other: usize| end(model, bodies, leg, slide, side, target, other);
    // Either end of the slide may be the one towards the base.
    let attempt = |parent: usize| -> Result<[End; 2], Finding> {
        Ok([walk(parent, base, platform)?, walk(1 - parent, platform, base)?])
    };
    let (parent_to_base, mut ends) = match (attempt(0), attempt(1)) {
        (Ok(ends), _) => (true, ends),
        (_, Ok(ends)) => (false, ends),
        // Seen from the wrong end every leg seems to branch.
        (Err(first), Err(second)) => return Err(if first.kind == K::LegBranches { second } else { first }),
    };
    decide(&mut ends).map_err(|text| finding(K::LegMobility, format!("the leg of joint '{}' {text}", edge.name)))?;
    let mut anchors = [Vector3::zeros(); 2];
    let rough = (ends[0].carry.translation.vector - ends[1].carry.translation.vector).norm();
    for (k, (anchor, end)) in anchors.iter_mut().zip(&ends).enumerate() {
        let what = ["base", "platform"][k];
        *anchor = common_point(end, what, &edge.name).map_err(|(kind, text)| finding(kind, text))?;
    }
    let between = anchors[1] - anchors[0];
    let length = between.norm();
    if !(length > 1e-9 * (1.0 + rough)) || !length.is_finite() {
        let text = format!("joint '{}': the anchors of its leg coincide at zero; move the slide's zero", edge.name);
        return Err(finding(K::EmptyRange, text));
    }
    for (k, (anchor, end)) in anchors.iter().zip(&ends).enumerate() {
        let miss = largest_miss(end, anchor);
        if !(miss <= allowed.distance(length)) {
            let text = format!(
                "the axes at the {} end of the leg of joint '{}' miss their common point by {:.3} mm, so it is not a \
                 point anchor; correct the origins, or widen the tolerance",
                ["base", "platform"][k],
                edge.name,
                1e3 * miss
            );
            return Err(finding(K::JointAxesDoNotMeet, text));
        }
    }
    let direction = between / length;
    let along = axis.dot(&direction);
    let off = axis.cross(&direction).norm().atan2(along.abs());
    if !(off <= allowed.angle(length)) {
        let text = format!(
            "joint '{}': its axis is {:.1} deg off the line of the anchors, so the length is not the joint coordinate plus \
             a constant; correct the axis or the origins",
            edge.name,
            off.to_degrees()
        );
        return Err(finding(K::SlideOffLeg, text));
    }
    check_turns(&ends, &direction, &edge.name).map_err(|(kind, text)| finding(kind, text))?;
    let into = |k: usize| ends[k].carry * nalgebra::Point3::from(anchors[k]);
    let local = |k: usize| {
        let (link, pose) = &ends[k].last;
        (*link, (pose.inverse() * nalgebra::Point3::from(anchors[k])).coords)
    };
    Ok(Measured {
        joint: edge.name.clone(),
        line: edge.line,
        edge: slide,
        reversed: (along > 0.0) != parent_to_base,
        anchors: [into(0).coords, into(1).coords],
        ends: [local(0), local(1)],
        length,
    })
}

fn branches(model: &Model, leg: &Part) -> Finding {
    let edge = leg.slides.first().map(|k| &model.edges[*k]);
    let name = edge.map_or(String::new(), |e| e.name.clone());
    let text = format!(
        "the leg of joint '{name}' branches or has a loop of its own between base and platform; a leg is one chain of joints"
    );
    Finding { kind: K::LegBranches, element: name, line: edge.and_then(|e| e.line), text }
}

/// A body, its pose in the frame of the leg, and the edge and the place in the list by which it was reached.
type Reached = (usize, Frame, Option<(usize, usize)>);

/// The bodies between the slide of a leg and the body at its end.
struct Walk {
    reached: Vec<Reached>,
    /// The edge into that body, and the place in the list from which it goes there.
    last: usize,
    from: usize,
    /// That body's pose in the frame of the leg.
    there: Frame,
}

/// Walks from a body of the leg, which has this pose, to the first of the `ends`; the leg must not branch on the way.
fn walk(
    model: &Model,
    bodies: &Bodies,
    leg: &Part,
    slide: usize,
    start: (usize, Frame),
    [target, other]: [usize; 2],
) -> Result<Walk, Finding> {
    // Breadth first; each body remembers the edge by which it was reached.
    let mut reached: Vec<Reached> = vec![(start.0, start.1, None)];
    let mut into_target = Vec::new();
    let mut inner = 0;
    let mut at = 0;
    while at < reached.len() {
        let (body, pose, _) = reached[at];
        for k in leg.edges.iter().filter(|k| **k != slide) {
            let e = &model.edges[*k];
            let [a, b] = e.sides.map(|s| bodies.of[s.link]);
            let (near, far) = match (a == body, b == body) {
                (true, true) => return Err(branches(model, leg)),
                (true, false) => (0, 1),
                (false, true) => (1, 0),
                (false, false) => continue,
            };
            let next = bodies.of[e.sides[far].link];
            let there = pose * bodies.frame(&e.sides[near]) * bodies.frame(&e.sides[far]).inverse();
            if next == target {
                into_target.push((*k, at, there));
            } else if next == other {
                return Err(branches(model, leg));
            } else {
                inner += 1;
                if !reached.iter().any(|r| r.0 == next) {
                    reached.push((next, there, Some((*k, at))));
                }
            }
        }
        at += 1;
    }
    // Every inner edge was seen from both of its bodies; a tree has one less than it has bodies.
    match (&into_target[..], inner == 2 * (reached.len() - 1)) {
        ([(last, from, there)], true) => Ok(Walk { last: *last, from: *from, there: *there, reached }),
        _ => Err(branches(model, leg)),
    }
}

/// Follows the leg from one side of its slide to a body.
fn end(
    model: &Model,
    bodies: &Bodies,
    leg: &Part,
    slide: usize,
    side: usize,
    target: usize,
    other: usize,
) -> Result<End, Finding> {
    let edge = &model.edges[slide];
    let start = edge.sides[side];
    let start_body = bodies.of[start.link];
    let inward = bodies.frame(&start).inverse();
    let finding = |kind, text| Finding { kind, element: edge.name.clone(), line: edge.line, text };
    if start_body == target {
        let text = format!(
            "joint '{}' slides on the base or on the platform itself, as in a hexaglide (6-PUS); a leg of this kind has \
             its joints at both ends, so implement `Mechanism` for it",
            edge.name
        );
        return Err(finding(K::SlideOnBase, text));
    }
    if start_body == other {
        return Err(branches(model, leg));
    }
    let Walk { reached, last, from, there } = walk(model, bodies, leg, slide, (start_body, inward), [target, other])?;
    let mut end = End { carry: there.inverse(), ..End::default() };
    let near = usize::from(bodies.of[model.edges[last].sides[1].link] == reached[from].0);
    let link = model.edges[last].sides[near].link;
    end.last = (link, reached[from].1 * bodies.frames[link]);
    let mut step = Some((last, from));
    while let Some((k, body)) = step {
        let e = &model.edges[k];
        let (body, pose, previous) = reached[body];
        let near = usize::from(bodies.of[e.sides[1].link] == body);
        let here = pose * bodies.frame(&e.sides[near]);
        end.add(e.motion, &here).map_err(|text| Finding {
            kind: K::UnsupportedJointType,
            element: e.name.clone(),
            line: e.line,
            text: format!("'{}' {text}", e.name),
        })?;
        step = previous;
    }
    Ok(end)
}
