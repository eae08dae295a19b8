//! What a graph without six proper legs lacks, in words.

use super::closures::Source;
use super::findings::Findings;
use super::graph::{Graph, Part};
use crate::files::finding::FindingKind as K;

impl Graph<'_> {
    /// What is wrong with the slides of a leg.
    pub(super) fn not_one_slide(&self, leg: &Part) -> Option<(K, String, Option<usize>, String)> {
        let edge = |k: usize| &self.model.edges[k];
        let leg_text = self.describe(leg);
        match (&leg.slides[..], &leg.passive_slides[..]) {
            ([_], []) => None,
            ([], []) => {
                let text = format!("the leg of {leg_text} has no prismatic joint; this kind has no passive legs");
                let element = leg.edges.first().map_or(String::new(), |k| edge(*k).name.clone());
                Some((K::LegWithoutSlide, element, leg.edges.first().and_then(|k| edge(*k).line), text))
            }
            (_, [slide, ..]) if edge(*slide).mimic.is_some() => {
                let text = format!(
                    "joint '{}' follows another joint (mimic); give the leg of {leg_text} one slide that is driven",
                    edge(*slide).name
                );
                Some((K::MimicSlide, edge(*slide).name.clone(), edge(*slide).line, text))
            }
            ([], [slide, ..]) => {
                let text =
                    format!("joint '{}' is not among the motors that are listed; add it to them", edge(*slide).name);
                Some((K::LegWithoutSlide, edge(*slide).name.clone(), edge(*slide).line, text))
            }
            (_, _) => {
                let slides = leg.slides.iter().chain(&leg.passive_slides).map(|k| format!("'{}'", edge(*k).name));
                let second = leg.slides.get(1).or(leg.passive_slides.first()).copied()?;
                let names = slides.collect::<Vec<_>>().join(", ");
                let text = format!(
                    "the leg of {leg_text} has several slides: {names}; a leg has one, so fix the others, or separate \
                     legs that share a body"
                );
                Some((K::LegWithTwoSlides, edge(second).name.clone(), edge(second).line, text))
            }
        }
    }

    /// The links of a part, in short.
    pub(super) fn describe(&self, part: &Part) -> String {
        let mut names: Vec<&str> = Vec::new();
        for (link, body) in self.bodies.of.iter().enumerate() {
            if part.bodies.contains(body) {
                names.push(&self.model.links[link]);
            }
            if names.len() > 3 {
                break;
            }
        }
        let more = if names.len() > 3 { " …" } else { "" };
        let shown: Vec<String> = names.iter().take(3).map(|n| format!("'{n}'")).collect();
        if shown.is_empty() { "a single joint".into() } else { shown.join(", ") + more }
    }

    /// No body is joined with the base by several legs: says why that may be.
    pub(super) fn no_platform(&self, base: usize, findings: &mut Findings) {
        let closed = self.model.edges.iter().any(|e| e.source != Source::Joint);
        if closed {
            let text = "fewer than 2 of 6 legs connect the base to any other body; check the closures, which have to \
                        connect the tips of the legs to the platform";
            findings.add(K::TooFewLegs, "", None, text);
            return;
        }
        let chain = self.around.iter().all(|a| a.len() <= 2) && self.around[base].len() <= 1;
        let accepted = "frames `closing_<leg>_1` and `closing_<leg>_2`, <loop_joint>, <drake:ball_constraint>, <loop>, \
                        <constraint>, <gazebo><joint>, a second parent, `close = [[\"tip\", \"anchor\"], …]` in a side \
                        file, or `--close tip=anchor`";
        if chain {
            let text =
                format!("the joints make one open chain, an arm; a parallel mechanism closes its loops by {accepted}");
            findings.add(K::SerialChain, "", None, text);
        } else {
            let hint = self.coincident_leaves();
            let text = format!("no closing pairs in any accepted form: {accepted}{hint}");
            findings.add(K::NoLoopClosures, "", None, text);
        }
    }

    /// Pairs of outer links that stand in one place at home: likely closures.
    fn coincident_leaves(&self) -> String {
        let places = self.model.places(&std::collections::HashMap::new());
        let mut is_parent = vec![false; self.model.links.len()];
        self.model.edges.iter().for_each(|e| is_parent[e.sides[0].link] = true);
        let leaves: Vec<usize> = (0..is_parent.len()).filter(|k| !is_parent[*k]).take(500).collect();
        let scale = places.iter().flatten().map(|p| p.translation.vector.norm()).fold(0.0, f64::max);
        let mut pairs = Vec::new();
        for (k, a) in leaves.iter().enumerate() {
            for b in &leaves[k + 1..] {
                let (Some(pa), Some(pb)) = (places[*a], places[*b]) else { continue };
                let apart = (pa.translation.vector - pb.translation.vector).norm();
                if self.bodies.of[*a] != self.bodies.of[*b] && apart <= 1e-4 * scale {
                    pairs.push(format!("--close {}={}", self.model.links[*a], self.model.links[*b]));
                }
            }
        }
        pairs.truncate(12);
        if pairs.is_empty() { String::new() } else { format!("; frames that coincide suggest {}", pairs.join(" ")) }
    }
}
