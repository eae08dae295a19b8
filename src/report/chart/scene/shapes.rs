//! The things of a scene as lines and areas on the picture.

use super::camera::{between, distance};
use super::labels::Obstacle;
use super::lines::{middle, path, pieces, runs};
use super::order::{Face, Item};
use super::stage::{Spot, Stage, tip, unit};
use super::{Arrow, Dot, LineSegment, Scene, Silhouette, Triad};
use crate::report::chart::marks::{MANY, arrow, marker, marker_class, palette_class};
use crate::report::chart::number::significant;

/// Colours get weaker with the depth in so many steps.
pub(super) const SHADES: usize = 6;
/// By so much, in radii of the scene, small things are brought forward, lest what they lie on hides them: joints are
/// in front of the legs and the ring that they join, dots in front of joints.
const JOINT: f64 = 0.11;
const DOT: f64 = 0.17;
/// The same for arrows; coordinate systems often lie along edges and legs.
const ARROW: f64 = 0.11;
const FRAME: f64 = 0.45;

/// All things of a scene on the picture.
#[derive(Debug, Default)]
pub(super) struct Drawing {
    pub items: Vec<Item>,
    pub faces: Vec<Face>,
    /// Lines over which labels should not lie.
    pub obstacles: Vec<Obstacle>,
}

/// The class of a colour at a depth.
pub(super) fn shade_class(colour: usize, shade: usize) -> String {
    let plain = palette_class(colour);
    if shade == 0 { plain } else { format!("{plain}-{shade}") }
}

impl Drawing {
    pub(super) fn new(scene: &Scene, stage: &Stage) -> Self {
        let mut all = Self::default();
        scene.outlines.iter().for_each(|o| all.outline(scene, stage, o));
        scene.legs.iter().for_each(|s| all.leg(scene, stage, s));
        scene.frames.iter().for_each(|f| all.frame(stage, f));
        scene.arrows.iter().for_each(|a| all.arrow(stage, a, scene.arrows.len() > MANY));
        scene.dots.iter().for_each(|d| all.dot(stage, d, scene.dots.len() > MANY));
        all
    }

    /// A line through spots; nothing is drawn if there are none.
    fn line(&mut self, stage: &Stage, colour: usize, spots: &[Spot], width: f64, tip: Option<String>) {
        let Some(middle) = middle(spots) else { return };
        let shade = shade(stage, middle.depth);
        self.items.push(Item {
            group: shade_class(colour, shade),
            class: "edge",
            width: Some(round(width * stage.camera.magnification(middle.depth))),
            d: path(spots, false),
            tip,
            halo: None,
            middle,
            depth: middle.depth,
        });
        // The wider a line is, the more is lost where a label lies on it.
        let weight = (width / 4.0).min(1.0);
        self.obstacles.extend(spots.windows(2).filter_map(|w| Some(Obstacle::new(w.first()?, w.last()?, weight))));
    }

    fn outline(&mut self, scene: &Scene, stage: &Stage, outline: &Silhouette) {
        let spots: Vec<Option<Spot>> = outline.points.iter().map(|p| stage.see(p)).collect();
        let whole: Option<Vec<Spot>> = spots.iter().copied().collect();
        if let Some(corners) = whole.filter(|c| outline.filled && c.len() > 2) {
            let depth = middle(&corners).map_or(0.0, |m| m.depth);
            self.faces.push(Face {
                group: shade_class(outline.colour, shade(stage, depth)),
                class: if outline.thin { "veil" } else { "band" },
                d: path(&corners, true),
                corners,
            });
        }
        for run in runs(&spots) {
            if outline.thin {
                self.thin(stage, outline, &run);
                continue;
            }
            let tip = size(scene, outline);
            for piece in pieces(stage, &run) {
                self.line(stage, outline.colour, &piece, 2.4, tip.clone());
            }
        }
    }

    /// A thin outline is one path: its transparency would make spots of the ends of pieces.
    fn thin(&mut self, stage: &Stage, outline: &Silhouette, run: &[Spot]) {
        let Some(middle) = middle(run) else { return };
        let closed = run.len() > 2 && run.first() == run.last();
        let ends = if closed { run.len() - 1 } else { run.len() };
        self.items.push(Item {
            group: shade_class(outline.colour, shade(stage, middle.depth)),
            class: "thin",
            width: None,
            d: path(run.get(..ends).unwrap_or(run), closed),
            tip: (!outline.name.trim().is_empty()).then(|| outline.name.clone()),
            halo: None,
            middle,
            depth: middle.depth,
        });
        self.obstacles.extend(run.windows(2).filter_map(|w| Some(Obstacle::new(w.first()?, w.last()?, 0.2))));
    }

    fn leg(&mut self, scene: &Scene, stage: &Stage, leg: &LineSegment) {
        let (Some(from), Some(to)) = (stage.see(&leg.from), stage.see(&leg.to)) else { return };
        let count = scene.legs.len();
        let width = if count <= 16 {
            3.8
        } else if count <= 60 {
            2.4
        } else {
            1.2
        };
        let tip = (count <= MANY).then(|| leg_tip(scene, leg));
        let cut = if count <= 60 { pieces(stage, &[from, to]) } else { vec![vec![from, to]] };
        for piece in &cut {
            let before = self.items.len();
            self.line(stage, leg.colour, piece, width, tip.clone());
            let (Some(item), Some(a), Some(b)) = (self.items.get_mut(before), piece.first(), piece.last()) else {
                continue;
            };
            // At its ends a leg must not interrupt what it is fixed to.
            let a = if a.at == from.at { stage.project(between(a.at, b.at, 0.35)) } else { *a };
            let b = if b.at == to.at { stage.project(between(b.at, a.at, 0.35)) } else { *b };
            let own = item.width.unwrap_or(width);
            item.halo = (count <= 60 && from.at != to.at).then(|| (round(own + 3.4), path(&[a, b], false)));
        }
        for end in [from, to].into_iter().filter(|_| count <= 60) {
            let size = stage.camera.magnification(end.depth);
            self.items.push(Item {
                group: shade_class(leg.colour, shade(stage, end.depth)),
                class: "mark",
                width: None,
                d: marker(0, end.px[0], end.px[1], round(0.9 * width * size)),
                tip: tip.clone(),
                halo: None,
                middle: end,
                depth: end.depth - JOINT,
            });
        }
    }

    fn frame(&mut self, stage: &Stage, frame: &Triad) {
        let Some(origin) = stage.see(&frame.origin) else { return };
        for axis in frame.axes {
            let Some(head) = stage.see(&tip(frame.origin, axis, frame.length)) else { continue };
            let size = stage.camera.magnification(head.depth);
            let Some(middle) = middle(&[origin, head]) else { continue };
            self.items.push(Item {
                group: "ink".to_owned(),
                class: "arrow",
                width: Some(round(1.5 * size)),
                d: arrow(origin.px, head.px, 8.0 * size),
                tip: (!frame.label.trim().is_empty()).then(|| frame.label.clone()),
                halo: None,
                middle,
                depth: middle.depth - FRAME,
            });
            self.obstacles.push(Obstacle::new(&origin, &head, 1.6));
        }
    }

    fn arrow(&mut self, stage: &Stage, own: &Arrow, many: bool) {
        let (Some(from), Some(to)) = (stage.see(&own.from), stage.see(&own.to)) else { return };
        let Some(middle) = middle(&[from, to]) else { return };
        let (depth, size) = grade(stage, middle.depth, many);
        self.items.push(Item {
            group: shade_class(own.colour, shade(stage, middle.depth)),
            class: "arrow",
            width: Some(round(if many { 0.9 } else { 1.4 } * size)),
            d: arrow(from.px, to.px, if many { 5.0 } else { 7.0 } * size),
            tip: text(&own.tip, &own.name).filter(|_| !many),
            halo: None,
            middle,
            depth: depth - ARROW,
        });
        self.obstacles.push(Obstacle::new(&from, &to, 1.0));
    }

    fn dot(&mut self, stage: &Stage, own: &Dot, many: bool) {
        let Some(at) = stage.see(&own.at) else { return };
        let (depth, size) = grade(stage, at.depth, many);
        self.items.push(Item {
            group: shade_class(own.colour, shade(stage, at.depth)),
            class: marker_class(),
            width: None,
            d: marker(own.colour, at.px[0], at.px[1], round(if many { 2.0 } else { 4.0 } * size)),
            tip: text(&own.tip, &own.name).filter(|_| !many),
            halo: None,
            middle: at,
            depth: depth - DOT,
        });
        self.obstacles.push(Obstacle::new(&at, &at, 1.0));
    }
}

/// The step of the shading at a depth.
fn shade(stage: &Stage, depth: f64) -> usize {
    ((stage.back(depth) * SHADES as f64) as usize).min(SHADES - 1)
}

/// The depth by which a thing is ordered, and its magnification. Of very many things, those of one shade are equal, so
/// that they become one path.
fn grade(stage: &Stage, depth: f64, many: bool) -> (f64, f64) {
    let depth = if many { stage.depth_of((shade(stage, depth) as f64 + 0.5) / SHADES as f64) } else { depth };
    (depth, stage.camera.magnification(depth))
}

/// A length in pixels with one decimal, never nothing.
fn round(v: f64) -> f64 {
    ((v * 10.0).round() / 10.0).max(0.3)
}

/// The first text that is not blank.
fn text(first: &str, second: &str) -> Option<String> {
    [first, second].into_iter().find(|t| !t.trim().is_empty()).map(str::to_owned)
}

/// Name, label and length of a leg.
fn leg_tip(scene: &Scene, leg: &LineSegment) -> String {
    let words: Vec<&str> = [leg.name.trim(), leg.label.trim()].into_iter().filter(|w| !w.is_empty()).collect();
    let (unit, metres) = unit(scene);
    let colon = if words.is_empty() { "" } else { ": " };
    format!("{}{colon}{} {unit} long", words.join(" "), significant(distance(leg.from, leg.to) / metres, 4))
}

/// Name of an outline and the largest distance of two of its corners.
fn size(scene: &Scene, outline: &Silhouette) -> Option<String> {
    let points = &outline.points;
    let name = outline.name.trim();
    if name.is_empty() || points.len() > 300 {
        return (!name.is_empty()).then(|| name.to_owned());
    }
    let across = points.iter().flat_map(|a| points.iter().map(|b| distance(*a, *b))).fold(0.0, f64::max);
    let (unit, metres) = unit(scene);
    Some(format!("{name}: {} {unit} across", significant(across / metres, 4)))
}
