//! The rigid bodies of a robot: links that are fixed to one another.

use std::collections::VecDeque;

use super::closures::{Frame, Motion};
use super::findings::Findings;
use super::model::{Model, Side};
use crate::files::finding::FindingKind as K;

/// Rigid bodies: links that are fixed to one another.
#[derive(Debug)]
pub(super) struct Bodies {
    /// Body of each link.
    pub(super) of: Vec<usize>,
    /// Pose of each link in its body.
    pub(super) frames: Vec<Frame>,
    pub(super) count: usize,
}

impl Bodies {
    /// Merges over fixed joints, and over fixed closures where joints do not do it.
    pub(super) fn of(model: &Model) -> Self {
        let n = model.links.len();
        let mut joined: Vec<Vec<(usize, Frame)>> = vec![Vec::new(); n];
        // Joints are exact and come first; a fixed closure of an export may be off by its gap.
        for e in model.edges.iter().filter(|e| e.motion == Motion::Fixed) {
            let [a, b] = e.sides;
            let step = a.frame * b.frame.inverse();
            joined[a.link].push((b.link, step));
            joined[b.link].push((a.link, step.inverse()));
        }
        let mut bodies = Self { of: vec![usize::MAX; n], frames: vec![Frame::identity(); n], count: 0 };
        for start in 0..n {
            if bodies.of[start] != usize::MAX {
                continue;
            }
            bodies.of[start] = bodies.count;
            let mut queue = VecDeque::from([start]);
            while let Some(link) = queue.pop_front() {
                for (other, step) in &joined[link] {
                    if bodies.of[*other] == usize::MAX {
                        bodies.of[*other] = bodies.count;
                        bodies.frames[*other] = bodies.frames[link] * step;
                        queue.push_back(*other);
                    }
                }
            }
            bodies.count += 1;
        }
        bodies
    }

    /// Reports fixed joints that put a link elsewhere than the others do.
    pub(super) fn check(&self, model: &Model, tolerance: f64, findings: &mut Findings) {
        for edge in model.edges[..model.joints].iter().filter(|e| e.motion == Motion::Fixed) {
            let [a, b] = edge.sides.map(|s| self.frame(&s));
            let off = (a.translation.vector - b.translation.vector).norm();
            let turned = a.rotation.angle_to(&b.rotation);
            if !(off <= tolerance && turned <= 1e-3) {
                let text = format!(
                    "fixed joint '{}' puts '{}' {:.3} mm and {:.2} deg off the place that other fixed joints give it; \
                     delete one of them",
                    edge.name,
                    model.links[edge.sides[1].link],
                    1e3 * off,
                    turned.to_degrees()
                );
                findings.add(K::ConflictingClosures, &edge.name, edge.line, text);
            }
        }
    }

    /// The frame of a side in its body.
    pub(super) fn frame(&self, side: &Side) -> Frame {
        self.frames[side.link] * side.frame
    }
}
