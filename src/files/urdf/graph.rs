//! Which bodies are base and platform, and which bodies and edges make the legs between them.
//!
//! Nothing depends on names: the platform is the body whose removal, with that of the base, leaves six parts that
//! touched both and have one actuated slide each.

use std::collections::{HashMap, HashSet};

use super::bodies::Bodies;
use super::closures::Motion;
use super::findings::Findings;
use super::model::Model;
use crate::files::finding::FindingKind as K;

/// What stands between base and platform, or hangs on one of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    pub(super) bodies: Vec<usize>,
    /// Edges with at least one end in the part, or between base and platform.
    pub(super) edges: Vec<usize>,
    touches: [bool; 2],
    /// Actuated slides, and slides that only follow.
    pub(super) slides: Vec<usize>,
    pub(super) passive_slides: Vec<usize>,
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
    pub(super) model: &'a Model,
    pub(super) bodies: &'a Bodies,
    /// Edge and the body at its other end.
    pub(super) around: Vec<Vec<(usize, usize)>>,
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
        let candidates: Vec<usize> = enough(6).filter(|platform| self.has_six(base, *platform)).collect();
        match candidates[..] {
            [platform] => self.six(base, platform, findings).map(|legs| (platform, legs)),
            [] if self.elsewhere(base, findings) => None,
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

    /// True if six legs with a slide each join two bodies.
    fn has_six(&self, base: usize, platform: usize) -> bool {
        let legs: Vec<Part> = self.parts(base, platform).into_iter().filter(Part::is_leg).collect();
        legs.len() == 6 && legs.iter().all(|l| l.slides.len() == 1)
    }

    /// Reports that six legs join two other bodies, such as a base that hangs on a joint of something else; false if none
    /// do.
    fn elsewhere(&self, base: usize, findings: &mut Findings) -> bool {
        let wide: Vec<usize> = (0..self.bodies.count).filter(|b| *b != base && self.around[*b].len() >= 6).collect();
        let pairs =
            wide.iter().enumerate().flat_map(|(k, first)| wide[k + 1..].iter().map(move |other| (*first, *other)));
        let Some((first, other)) = pairs.into_iter().find(|(first, other)| self.has_six(*first, *other)) else {
            return false;
        };
        let [base, first_name, other_name] = [base, first, other].map(|body| self.name(body));
        let text = format!(
            "no legs stand on the body of '{base}'; six join '{first_name}' and '{other_name}', so state which of them is the \
             base: `--base-link {first_name}` or `--base-link {other_name}`"
        );
        findings.add(K::TooFewLegs, first_name, self.line(first), text);
        true
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
}
