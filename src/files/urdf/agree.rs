//! Closures from several sources: which one counts, and whether they agree.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::bodies::Bodies;
use super::closures::{Closure, Frame, Motion};
use super::findings::Findings;
use super::model::{Edge, Model};
use crate::files::finding::FindingKind as K;

/// Adds the closures to the model, the preferred sources first. What closes one pair of bodies twice must agree.
pub(super) fn add_closures(
    model: &mut Model,
    mut closures: Vec<Closure>,
    home: &[Option<Frame>],
    findings: &mut Findings,
) {
    closures.sort_by_key(|c| c.source);
    let bodies = Bodies::of(model);
    let tolerance = 1e-4 * size(model);
    let mut between: HashMap<[usize; 2], usize> = HashMap::new();
    let key = |edge: &Edge| {
        let mut pair = edge.sides.map(|s| bodies.of[s.link]);
        pair.sort_unstable();
        pair
    };
    for (k, edge) in model.edges.iter().enumerate() {
        if !matches!(edge.motion, Motion::Floating | Motion::Fixed) {
            between.entry(key(edge)).or_insert(k);
        }
    }
    if let Some(first) = closures.iter().find(|c| c.ends.iter().any(|e| e.frame.is_none())) {
        let text = format!(
            "{} '{}' and others like it state their place in '{}' or similar links only; the other place is taken at \
             home, so the anchors are right only if the file is assembled there: at q = 0, or at `--home joint=value`",
            first.source, first.name, first.ends[0].link
        );
        findings.add(K::PlaceTakenAtHome, &first.name, first.line, text);
    }
    for closure in &closures {
        let before = model.edges.len();
        model.close(closure, home, findings);
        let Some(new) = model.edges.get(before) else { continue };
        let pair = key(new);
        if pair[0] == pair[1] {
            let text = format!(
                "{} '{}' closes '{}' with '{}', which are fixed to one another; pair a frame of the leg with one of the \
                 platform",
                closure.source, closure.name, closure.ends[0].link, closure.ends[1].link
            );
            findings.add(K::ClosureWithinOneBody, &closure.name, closure.line, text);
            model.edges.pop();
            continue;
        }
        let Some(first) = between.get(&pair).copied() else {
            between.insert(pair, before);
            continue;
        };
        if let Some(motion) = agreed(&model.edges[first], new, &bodies, tolerance) {
            model.edges[first].motion = motion;
        } else {
            let other = &model.edges[first];
            let text = format!(
                "{} '{}' and {} '{}' close the same two bodies at different places or in different ways; delete one \
                 of them",
                closure.source, closure.name, other.source, other.name
            );
            findings.add(K::ConflictingClosures, &closure.name, closure.line, text);
        }
        model.edges.pop();
    }
}

/// Freedoms of two closures of the same bodies, if they agree.
fn agreed(first: &Edge, second: &Edge, bodies: &Bodies, tolerance: f64) -> Option<Motion> {
    let swapped = bodies.of[first.sides[0].link] != bodies.of[second.sides[0].link];
    let other = if swapped { [1, 0] } else { [0, 1] };
    for (k, other) in other.into_iter().enumerate() {
        let place = |edge: &Edge, side: usize| bodies.frame(&edge.sides[side]).translation.vector;
        if !((place(first, k) - place(second, other)).norm() <= tolerance) {
            return None;
        }
    }
    match (first.motion, second.motion) {
        (Motion::Undecided, Motion::Hinge(axis)) => {
            // The axis is kept in the first frame of the record that stays.
            let of_second = bodies.frame(&second.sides[0]).rotation * axis;
            let side = if swapped { 1 } else { 0 };
            // Frames that are paired coincide, so either body carries the axis over.
            let local = bodies.frame(&first.sides[side]).rotation.inverse() * of_second;
            Some(Motion::Hinge(local))
        }
        (Motion::Undecided, other) => Some(other),
        (other, Motion::Undecided) => Some(other),
        (Motion::Hinge(a) | Motion::Slide(a), Motion::Hinge(b) | Motion::Slide(b))
            if std::mem::discriminant(&first.motion) == std::mem::discriminant(&second.motion) =>
        {
            // Seen in the body of the first frame of the record that stays; an axis has no sense.
            let near = bodies.frame(&first.sides[0]).rotation;
            let far = |axis: Vector3<f64>| {
                if !swapped {
                    return bodies.frame(&second.sides[0]).rotation * axis;
                }
                // The axis is in the other body, and the frames that are paired coincide.
                let to_first = near * bodies.frame(&first.sides[1]).rotation.inverse();
                to_first * bodies.frame(&second.sides[0]).rotation * axis
            };
            ((near * a).cross(&far(b)).norm() <= 1e-3).then_some(first.motion)
        }
        (a, b) => (std::mem::discriminant(&a) == std::mem::discriminant(&b)).then_some(a),
    }
}

/// The longest step from a link to a joint: the size of the robot, roughly.
pub(super) fn size(model: &Model) -> f64 {
    model.edges[..model.joints].iter().map(|e| e.sides[0].frame.translation.vector.norm()).fold(0.0, f64::max)
}
