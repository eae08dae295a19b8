//! The links whose frames are those of base and platform, and whether their names agree with their place in the tree.

use super::bodies::Bodies;
use super::closures::Motion;
use super::findings::Findings;
use super::model::Model;
use crate::files::finding::FindingKind as K;

/// How links of the base and of the platform are usually called, by their first letters.
const BASE: [&str; 1] = ["base"];
const PLATFORM: [&str; 2] = ["platform", "top"];

/// The bodies of base and platform as they were found.
pub(super) struct Choice<'a> {
    pub(super) model: &'a Model,
    pub(super) bodies: &'a Bodies,
    pub(super) base: usize,
    pub(super) platform: usize,
}

impl Choice<'_> {
    fn links(&self, body: usize) -> impl Iterator<Item = usize> {
        (0..self.model.links.len()).filter(move |l| self.bodies.of[*l] == body)
    }

    fn is_called(&self, link: usize, names: &[&str]) -> bool {
        let name = self.model.links[link].to_lowercase();
        names.iter().any(|n| name.starts_with(n))
    }

    /// Reports names that say the opposite: a tree may be rooted in its platform.
    pub(super) fn check_names(&self, findings: &mut Findings) {
        let called = |body: usize, names: &[&str]| self.links(body).find(|l| self.is_called(*l, names));
        let (up, down) = (called(self.platform, &BASE), called(self.base, &PLATFORM));
        let name = |link: usize| &self.model.links[link];
        let place = |link: usize| (name(link).clone(), self.model.lines.get(link).copied());
        match (up, down) {
            (Some(b), Some(p)) => {
                let text = format!(
                    "the tree has its root in '{}' and the legs carry '{}', so base and platform would be swapped; state \
                     `--base-link {}`, or `--base-link {}` if that is intended",
                    name(p),
                    name(b),
                    name(b),
                    name(p)
                );
                let (element, line) = place(b);
                findings.add(K::AmbiguousPlatform, element, line, text);
            }
            (Some(b), None) => {
                let text = format!(
                    "'{}' is read as the platform, since the root of the tree is on the other body; if it is the base, state \
                     `--base-link {}`",
                    name(b),
                    name(b)
                );
                let (element, line) = place(b);
                findings.add(K::SwappedNames, element, line, text);
            }
            (None, Some(p)) => {
                let text = format!(
                    "'{}' is read as the base, since the root of the tree is on its body; if it is the platform, state \
                     `--base-link` with a link of the other body",
                    name(p)
                );
                let (element, line) = place(p);
                findings.add(K::SwappedNames, element, line, text);
            }
            (None, None) => {}
        }
    }

    /// The link whose frame is the base frame.
    pub(super) fn base(&self, root: usize, findings: &mut Findings) -> usize {
        let mut usual = ["base_link", "base"].iter().filter_map(|name| self.model.link(name));
        let of_base = |l: &usize| self.bodies.of[*l] == self.base;
        let chosen = usual.find(of_base).or(Some(root).filter(of_base)).or_else(|| self.links(self.base).next());
        let chosen = chosen.unwrap_or(root);
        self.tell(chosen, "base", &BASE, findings);
        chosen
    }

    /// The link whose frame is the platform frame.
    pub(super) fn platform(&self, findings: &mut Findings) -> usize {
        let chosen = self.platform_link();
        self.tell(chosen, "platform", &PLATFORM, findings);
        chosen
    }

    fn platform_link(&self) -> usize {
        let joints = &self.model.edges[..self.model.joints];
        let mut floating = joints.iter().filter(|e| e.motion == Motion::Floating).map(|e| e.sides[1].link);
        if let Some(link) = floating.find(|l| self.bodies.of[*l] == self.platform) {
            return link;
        }
        let named: Vec<usize> = self.links(self.platform).filter(|l| self.is_called(*l, &PLATFORM)).collect();
        if let [link] = named[..] {
            return link;
        }
        let fixed_children =
            |l: &usize| joints.iter().filter(|e| e.motion == Motion::Fixed && e.sides[0].link == *l).count();
        self.links(self.platform).max_by_key(|l| (fixed_children(l), usize::MAX - l)).unwrap_or_default()
    }

    /// Says which link was chosen, unless its name says so.
    fn tell(&self, link: usize, what: &str, names: &[&str], findings: &mut Findings) {
        if !self.is_called(link, names) {
            let name = &self.model.links[link];
            let text =
                format!("the frame of link '{name}' is taken as the {what} frame; `--{what}-link` names another");
            findings.add(K::Note, name, self.model.lines.get(link).copied(), text);
        }
    }
}
