//! The home pose: where the joints of the file put the platform, if that closes every loop.

use std::collections::HashMap;

use nalgebra::Point3;

use super::closures::Frame;
use super::findings::Findings;
use super::found::FoundLeg;
use super::leg::{Allowed, Measured};
use super::model::Model;
use crate::conditions::Conditions;
use crate::files::finding::FindingKind as K;
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
        let lengths = self.lengths(legs, values, findings);
        let mean = lengths.iter().sum::<f64>() / lengths.len().max(1) as f64;
        let tolerance = allowed.distance(mean);
        let gaps = self.gaps(legs, &tree, &lengths);
        let Some(worst) = (0..gaps.len()).max_by(|a, b| gaps[*a].total_cmp(&gaps[*b])) else { return Some(tree) };
        let gap = gaps[worst];
        if gap <= tolerance {
            return Some(tree);
        }
        let (line, worst) = (self.measured[worst].line, &legs[worst].joint);
        let apart: Vec<&str> =
            legs.iter().zip(&gaps).filter(|(_, g)| !(**g <= tolerance)).map(|(l, _)| l.joint.as_str()).collect();
        let which = if apart.len() < legs.len() {
            format!(" (of {} legs, only these: {})", legs.len(), apart.join(", "))
        } else {
            String::new()
        };
        let solved = nearest(legs, &lengths, &tree);
        let Some(pose) = solved else {
            let text = format!(
                "at its home joint coordinates the leg of joint '{worst}' misses its anchor by {:.3} mm{which}, and \
                 no pose near that of the file fits the lengths; the home pose is searched for above the base \
                 instead. Give the assembled joint coordinates by `--home joint=value`, or [home] in a side file",
                1e3 * gap
            );
            findings.add(K::HomeNotClosed, worst, line, text);
            return None;
        };
        let text = format!(
            "at its home joint coordinates the leg of joint '{worst}' misses its anchor by {:.3} mm{which}; the home \
             pose is solved from the lengths instead. Either the anchors and lengths are right and the platform is \
             not at its home pose: correct that pose, or state `--home joint=value`; or a closure joins the wrong \
             pair: correct that",
            1e3 * gap
        );
        findings.add(K::HomeNotClosed, worst, line, text);
        Some(pose)
    }

    /// Lengths of the legs at home; slides outside their limits are reported.
    fn lengths(&self, legs: &[FoundLeg], values: &HashMap<usize, f64>, findings: &mut Findings) -> Vec<f64> {
        let mut lengths = Vec::with_capacity(legs.len());
        for (leg, measured) in legs.iter().zip(self.measured) {
            let q = values.get(&measured.edge).copied().unwrap_or(0.0);
            lengths.push(if leg.reversed { leg.length - q } else { leg.length + q });
            if let Some([lower, upper]) = self.model.edges[measured.edge].limit.filter(|[a, b]| q < *a || q > *b) {
                let (name, middle) = (&leg.joint, 0.5 * (lower + upper));
                let text = format!(
                    "joint '{name}' is at {q} m at home, outside its limits {lower} to {upper} m; mid-travel would be \
                     `--home {name}={middle}`"
                );
                findings.add(K::HomeOutsideLimits, name, measured.line, text);
            }
        }
        lengths
    }

    /// The largest distance between the anchors of each leg and those of its bodies.
    fn gaps(&self, legs: &[FoundLeg], tree: &Pose, lengths: &[f64]) -> Vec<f64> {
        let gap = |((leg, measured), length): ((&FoundLeg, &Measured), &f64)| {
            let mut gap = ((tree.place(&leg.platform) - leg.base).norm() - length).abs();
            for (k, anchor) in [leg.base, leg.platform].iter().enumerate() {
                let (link, local) = &measured.ends[k];
                if let (Some(of_leg), Some(of_body)) = (self.places[*link], self.places[self.links[k]]) {
                    gap = gap.max((of_leg * Point3::from(*local) - of_body * Point3::from(*anchor)).norm());
                }
            }
            gap
        };
        legs.iter().zip(self.measured).zip(lengths).map(gap).collect()
    }
}

/// The pose nearest to that of the tree that fits the lengths.
fn nearest(legs: &[FoundLeg], lengths: &[f64], tree: &Pose) -> Option<Pose> {
    let as_leg = |(l, length): (&FoundLeg, &f64)| Leg {
        platform: l.platform,
        base: l.base,
        length: *length,
        length_offset: 0.0,
        stroke: None,
    };
    let all: Vec<Leg> = legs.iter().zip(lengths).map(as_leg).collect();
    let mechanism = SixHardpoint::new("home", &all, Some(*tree), None).ok()?;
    mechanism.forward(mechanism.values(), lengths, &Conditions::unknown(), tree).ok()
}
