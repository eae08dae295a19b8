//! The home pose: where the joints of the file put the platform, if that closes every loop.

use std::collections::HashMap;

use nalgebra::Point3;

use super::closures::Frame;
use super::extract::FoundLeg;
use super::finding::{FindingKind as K, Findings};
use super::leg::{Allowed, Measured};
use super::model::Model;
use crate::mechanism::{Leg, Mechanism, SixHardpoint};
use crate::pose::Pose;

/// The mechanism as the joints of the file place it.
pub(super) struct Assembly<'a> {
    pub(super) model: &'a Model,
    pub(super) measured: &'a [Measured],
    pub(super) places: &'a [Option<Frame>],
    /// Links of the base frame and of the platform frame.
    pub(super) links: [usize; 2],
}

impl Assembly<'_> {
    /// The home pose: that of the joints if they close every loop, else the nearest that fits the lengths.
    pub(super) fn home(
        &self,
        legs: &[FoundLeg],
        tree: Pose,
        values: &HashMap<usize, f64>,
        allowed: Allowed,
        findings: &mut Findings,
    ) -> Option<Pose> {
        let mut lengths = Vec::with_capacity(legs.len());
        for (leg, measured) in legs.iter().zip(self.measured) {
            let q = values.get(&measured.edge).copied().unwrap_or(0.0);
            lengths.push(if leg.reversed { leg.length - q } else { leg.length + q });
            if let Some([lower, upper]) = self.model.edges[measured.edge].limit.filter(|[a, b]| q < *a || q > *b) {
                let (name, middle) = (&leg.joint, 0.5 * (lower + upper));
                let text = format!(
                    "joint '{name}' stands at {q} m at home, outside its limits {lower} to {upper} m; its middle would be \
                     `--home {name}={middle}`"
                );
                findings.add(K::HomeOutsideLimits, name, measured.line, text);
            }
        }
        let mean = lengths.iter().sum::<f64>() / lengths.len().max(1) as f64;
        let tolerance = allowed.distance(mean);
        let (gap, worst) = self.largest_gap(legs, &tree, &lengths);
        if gap <= tolerance {
            return Some(tree);
        }
        let as_leg = |(l, length): (&FoundLeg, &f64)| Leg {
            platform: l.platform,
            base: l.base,
            length: *length,
            length_offset: 0.0,
            stroke: None,
        };
        let all: Vec<Leg> = legs.iter().zip(&lengths).map(as_leg).collect();
        let solved = SixHardpoint::new("home", &all, Some(tree), None).ok().and_then(|m| {
            let at = crate::conditions::Conditions::unknown();
            m.forward(m.values(), &lengths, &at, &tree).ok()
        });
        let Some(pose) = solved else {
            let text = format!(
                "at joint coordinates zero the leg of joint '{worst}' misses its anchor by {:.3} mm, and no pose near that of \
                 the file fits the lengths; the home pose is sought above the base instead. Give the assembled joint \
                 coordinates by `--home joint=value`, or [home] in a side file",
                1e3 * gap
            );
            findings.add(K::HomeNotClosed, worst, None, text);
            return None;
        };
        let text = format!(
            "at its joint coordinates of home the leg of joint '{worst}' misses its anchor by {:.3} mm; the home pose is \
             solved from the lengths instead. Anchors and lengths hold; correct the pose of the platform in the file, or \
             state `--home joint=value`",
            1e3 * gap
        );
        findings.add(K::HomeNotClosed, worst, None, text);
        Some(pose)
    }

    /// The largest distance between an anchor of a leg and that of its body, and the joint of that leg.
    fn largest_gap(&self, legs: &[FoundLeg], tree: &Pose, lengths: &[f64]) -> (f64, String) {
        let mut largest = (0.0, String::new());
        for ((leg, measured), length) in legs.iter().zip(self.measured).zip(lengths) {
            let mut gap = ((tree.place(&leg.platform) - leg.base).norm() - length).abs();
            for (k, anchor) in [leg.base, leg.platform].iter().enumerate() {
                let (link, local) = &measured.ends[k];
                if let (Some(of_leg), Some(of_body)) = (self.places[*link], self.places[self.links[k]]) {
                    gap = gap.max((of_leg * Point3::from(*local) - of_body * Point3::from(*anchor)).norm());
                }
            }
            if !(gap <= largest.0) {
                largest = (gap, leg.joint.clone());
            }
        }
        largest
    }
}
