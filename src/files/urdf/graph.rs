//! Which bodies are base and platform, and which bodies and edges make the legs between them.
//!
//! Nothing depends on names: the platform is the body whose removal, with that of the base, leaves six parts that
//! touched both and have one actuated slide each.

use std::collections::{HashMap, HashSet};

use super::closures::{Motion, Source};
use super::finding::{FindingKind as K, Findings};
use super::model::{Bodies, Model};

/// What stands between base and platform, or hangs on one of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    pub(super) bodies: Vec<usize>,
    /// Edges with at least one end in the part, or between base and platform.
    pub(super) edges: Vec<usize>,
    touches: [bool; 2],
    /// Actuated slides, and slides that only follow.
    pub(super) slides: Vec<usize>,
    passive_slides: Vec<usize>,
    /// Slides that lead to nothing.
    dead_ends: Vec<usize>,
}

impl Part {
    fn is_leg(&self) -> bool {
        self.touches == [true; 2]
    }
}

/// The edges that leave some freedom and not all, by body.
pub(super) struct Graph<'a> {
    model: &'a Model,
    pub(super) bodies: &'a Bodies,
    /// Edge and the body at its other end.
    around: Vec<Vec<(usize, usize)>>,
    actuated: &'a dyn Fn(usize) -> bool,
}

impl<'a> Graph<'a> {
    /// `actuated` says of a slide that is no mimic whether it is driven.
    pub(super) fn new(model: &'a Model, bodies: &'a Bodies, actuated: &'a dyn Fn(usize) -> bool) -> Self {
        let mut around = vec![Vec::new(); bodies.count];
        for (k, edge) in model.edges.iter().enumerate() {
            if matches!(edge.motion, Motion::Fixed | Motion::Floating) {
                continue;
            }
            let [a, b] = edge.sides.map(|s| bodies.of[s.link]);
            around[a].push((k, b));
            if a != b {
                around[b].push((k, a));
            }
        }
        Self { model, bodies, around, actuated }
    }

    /// The platform and the six legs, in the order of their slides in the file.
    pub(super) fn legs(
        &self,
        base: usize,
        named: Option<usize>,
        findings: &mut Findings,
    ) -> Option<(usize, Vec<Part>)> {
        if let Some(platform) = named {
            return self.six(base, platform, findings).map(|legs| (platform, legs));
        }
        let enough = |least: usize| {
            let wide = move |body: &usize| *body != base && self.around[*body].len() >= least;
            (0..self.bodies.count).filter(wide)
        };
        let good = |platform: &usize| {
            let legs = self.parts(base, *platform).into_iter().filter(Part::is_leg).collect::<Vec<_>>();
            legs.len() == 6 && legs.iter().all(|l| l.slides.len() == 1)
        };
        let candidates: Vec<usize> = enough(6).filter(good).collect();
        match candidates[..] {
            [platform] => self.six(base, platform, findings).map(|legs| (platform, legs)),
            [] => {
                let count = |p: &usize| self.parts(base, *p).iter().filter(|part| part.is_leg()).count();
                let best = enough(2).map(|p| (count(&p), p)).max_by_key(|(legs, p)| (*legs, usize::MAX - p));
                match best.filter(|(legs, _)| *legs >= 2) {
                    Some((_, platform)) => drop(self.six(base, platform, findings)),
                    None => self.no_platform(base, findings),
                }
                None
            }
            [..] => {
                let names = candidates.iter().map(|b| format!("'{}'", self.name(*b))).collect::<Vec<_>>().join(", ");
                let text = format!("{names} could each be the platform; name one with `--platform-link`");
                findings.add(K::AmbiguousPlatform, "", None, text);
                None
            }
        }
    }

    /// The first link of a body.
    fn name(&self, body: usize) -> &str {
        let link = self.bodies.of.iter().position(|b| *b == body);
        link.map_or("", |k| self.model.links[k].as_str())
    }

    /// The line of that link.
    fn line(&self, body: usize) -> Option<usize> {
        let link = self.bodies.of.iter().position(|b| *b == body)?;
        self.model.lines.get(link).copied()
    }

    /// What is left when base and platform are taken away.
    fn parts(&self, base: usize, platform: usize) -> Vec<Part> {
        let mut part_of = vec![usize::MAX; self.bodies.count];
        let mut parts = Vec::new();
        for start in (0..self.bodies.count).filter(|b| *b != base && *b != platform) {
            if part_of[start] != usize::MAX {
                continue;
            }
            let mut part = Part { bodies: vec![start], ..Part::default() };
            part_of[start] = parts.len();
            let mut at = 0;
            while at < part.bodies.len() {
                let body = part.bodies[at];
                at += 1;
                for (edge, other) in &self.around[body] {
                    part.edges.push(*edge);
                    if *other == base {
                        part.touches[0] = true;
                    } else if *other == platform {
                        part.touches[1] = true;
                    } else if part_of[*other] == usize::MAX {
                        part_of[*other] = parts.len();
                        part.bodies.push(*other);
                    }
                }
            }
            parts.push(part);
        }
        // A joint straight from base to platform is a leg without a body of its own.
        let straight = self.around[base].iter().filter(|(_, other)| *other == platform);
        parts.extend(straight.map(|(edge, _)| Part { edges: vec![*edge], touches: [true; 2], ..Part::default() }));
        for part in &mut parts {
            part.edges.sort_unstable();
            part.edges.dedup();
            let is_slide = |k: &&usize| matches!(self.model.edges[**k].motion, Motion::Slide(_));
            if part.is_leg() {
                let lost = self.prune(part);
                part.dead_ends = lost.iter().filter(is_slide).copied().collect();
            }
            let slides = part.edges.iter().filter(is_slide).copied();
            let drives = |k: &usize| self.model.edges[*k].mimic.is_none() && (self.actuated)(*k);
            (part.slides, part.passive_slides) = slides.partition(drives);
        }
        parts
    }

    /// Takes away what hangs on a leg and leads nowhere, such as a sensor or a cover, and returns its edges.
    fn prune(&self, part: &mut Part) -> Vec<usize> {
        let mut degree: HashMap<usize, usize> = part.bodies.iter().map(|b| (*b, self.around[*b].len())).collect();
        let mut outer: Vec<usize> = part.bodies.iter().copied().filter(|b| self.around[*b].len() == 1).collect();
        let mut lost = HashSet::new();
        while let Some(body) = outer.pop() {
            degree.remove(&body);
            for (edge, other) in &self.around[body] {
                if lost.insert(*edge)
                    && let Some(left) = degree.get_mut(other)
                {
                    *left -= 1;
                    if *left == 1 {
                        outer.push(*other);
                    }
                }
            }
        }
        part.bodies.retain(|b| degree.contains_key(b));
        part.edges.retain(|e| !lost.contains(e));
        let mut lost: Vec<usize> = lost.into_iter().collect();
        lost.sort_unstable();
        lost
    }

    /// The six legs of a platform, or a report on what each lacks.
    fn six(&self, base: usize, platform: usize, findings: &mut Findings) -> Option<Vec<Part>> {
        let parts = self.parts(base, platform);
        let (mut legs, others): (Vec<Part>, Vec<Part>) = parts.into_iter().partition(Part::is_leg);
        if legs.is_empty() {
            let name = self.name(platform);
            let text =
                format!("no leg connects the base to the body of '{name}'; close its loops, or name another platform");
            findings.add(K::DisconnectedPlatform, name, self.line(platform), text);
            return None;
        }
        if legs.iter().all(|l| l.slides.is_empty() && l.passive_slides.is_empty()) {
            let text = format!(
                "none of the {} legs has a prismatic joint; they look driven by revolute joints (6-RSS, a rotary Stewart \
                 platform), which is not a six-hardpoint mechanism: implement `Mechanism` for it",
                legs.len()
            );
            findings.add(K::NoPrismaticActuators, "", None, text);
            return None;
        }
        let mut wrong = false;
        for leg in &legs {
            let found = self.not_one_slide(leg);
            wrong |= found.is_some();
            found.into_iter().for_each(|(kind, element, line, text)| findings.add(kind, element, line, text));
        }
        if legs.len() != 6 {
            let loose: Vec<String> = others.iter().filter(|p| !p.slides.is_empty()).map(|p| self.describe(p)).collect();
            let hint = if loose.is_empty() {
                String::new()
            } else {
                format!("; not attached to both: {}, close it with `--close tip=anchor`", loose.join("; "))
            };
            let (kind, advice) = match legs.len() {
                0..6 => (K::TooFewLegs, "add what is missing"),
                _ => (K::TooManyLegs, "delete those that are not, or name the platform with `--platform-link`"),
            };
            let text = format!(
                "{} of 6 legs connect the base to the body of '{}'{hint}; {advice}",
                legs.len(),
                self.name(platform)
            );
            findings.add(kind, self.name(platform), self.line(platform), text);
            wrong = true;
        }
        for edge in legs.iter().flat_map(|l| &l.dead_ends).map(|k| &self.model.edges[*k]) {
            let text = format!("joint '{}' slides on a leg but leads to nothing, so it is ignored", edge.name);
            findings.add(K::Note, &edge.name, edge.line, text);
        }
        legs.sort_by_key(|l| l.slides.first().copied());
        (!wrong).then_some(legs)
    }

    /// What is wrong with the slides of a leg.
    fn not_one_slide(&self, leg: &Part) -> Option<(K, String, Option<usize>, String)> {
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
    fn describe(&self, part: &Part) -> String {
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
    fn no_platform(&self, base: usize, findings: &mut Findings) {
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
