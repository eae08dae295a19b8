//! Labels at places where they hide little and no other text.

use super::Scene;
use super::camera::between;
use super::stage::{Spot, Stage, tip};
use crate::report::chart::number::{shorten, width};
use crate::report::chart::svg::{Anchor, Canvas, Font, TextBox};

const LEG: Font = Font { bold: true, ..Font::new(13.0, "h", Anchor::Middle) };
const FRAME: Font = Font { bold: true, ..Font::new(12.5, "h", Anchor::Middle) };
const AXIS: Font = Font::new(12.0, "h", Anchor::Middle);
/// Longest label in pixels, and that of an arrow.
const LONGEST: f64 = 150.0;
const LONGEST_OF_ARROW: f64 = 240.0;
/// Harm of a label on its own arrow, besides that on any arrow.
const OWN: f64 = 3.0;

/// A line on the picture with the weight of the harm that a label on it does.
#[derive(Clone, Copy, Debug)]
pub(super) struct Obstacle {
    from: [f64; 2],
    to: [f64; 2],
    weight: f64,
}

impl Obstacle {
    pub(super) fn new(from: &Spot, to: &Spot, weight: f64) -> Self {
        Self { from: from.px, to: to.px, weight }
    }

    /// Whether it crosses a box (Liang and Barsky's clipping).
    fn crosses(&self, own: &TextBox) -> bool {
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        let low = [own.x0 - 1.5, own.y0 - 1.5];
        let high = [own.x1 + 1.5, own.y1 + 1.5];
        for i in 0..2 {
            let (start, step) = (self.from[i], self.to[i] - self.from[i]);
            if step.abs() < 1e-9 {
                if start < low[i] || start > high[i] {
                    return false;
                }
                continue;
            }
            let (a, b) = ((low[i] - start) / step, (high[i] - start) / step);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        enter <= leave
    }
}

/// The part of the picture for labels, with what is in it.
struct Places<'a> {
    canvas: &'a mut Canvas,
    obstacles: Vec<Obstacle>,
    /// Upper and lower edge.
    rows: (f64, f64),
}

impl Places<'_> {
    /// Writes a text centred at the place with the least harm; a text without a free place is left out.
    fn put(&mut self, font: &Font, text: &str, places: impl IntoIterator<Item = [f64; 2]>) {
        let mut best: Option<(f64, f64, f64)> = None;
        for (rank, [x, y]) in places.into_iter().enumerate() {
            let y = y + 0.28 * font.size;
            let own = TextBox::of(font, x, y, text);
            let inside =
                own.x0 >= 2.0 && own.x1 <= self.canvas.width - 2.0 && own.y0 >= self.rows.0 && own.y1 <= self.rows.1;
            if !inside || self.canvas.boxes.iter().any(|b| b.overlaps(&own)) {
                continue;
            }
            // Later places are a little worse, so that labels stay close to what they name.
            let harm: f64 = self.obstacles.iter().filter(|o| o.crosses(&own)).map(|o| o.weight).sum();
            let harm = harm + 0.04 * rank as f64;
            if best.is_none_or(|(least, ..)| harm < least) {
                best = Some((harm, x, y));
            }
        }
        if let Some((_, x, y)) = best {
            self.canvas.text(font, x, y, text);
        }
    }
}

/// Half the size of the box of a text.
fn half(font: &Font, text: &str) -> [f64; 2] {
    [0.5 * width(text, font.size, font.bold), 0.52 * font.size]
}

/// Places around a pixel at growing distances, the first ones in the wanted direction.
fn around(at: [f64; 2], wanted: [f64; 2], half: [f64; 2]) -> Vec<[f64; 2]> {
    let start = wanted[1].atan2(wanted[0]);
    let turns = [0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 4.0];
    let place = |away: f64, turn: f64| {
        let (s, c) = (start + turn * std::f64::consts::FRAC_PI_4).sin_cos();
        // The edge of the box, not its middle, is that far away.
        let box_reach = (half[0] / c.abs().max(1e-9)).min(half[1] / s.abs().max(1e-9));
        [at[0] + c * (away + box_reach), at[1] + s * (away + box_reach)]
    };
    [4.0, 11.0, 20.0].into_iter().flat_map(|away| turns.map(|turn| place(away, turn))).collect()
}

/// Places beside a leg, the first ones next to its middle.
fn beside(stage: &Stage, from: Spot, to: Spot, half: [f64; 2]) -> Vec<[f64; 2]> {
    let (dx, dy) = (to.px[0] - from.px[0], to.px[1] - from.px[1]);
    let length = dx.hypot(dy).max(1e-9);
    let normal = [dy / length, -dx / length];
    let reach = normal[0].abs() * half[0] + normal[1].abs() * half[1];
    let mut all = Vec::new();
    for away in [4.5, 9.0, 16.0] {
        for s in [0.5, 0.42, 0.58, 0.34, 0.66, 0.26, 0.74, 0.18, 0.82] {
            let spot = stage.project(between(from.at, to.at, s));
            let off = reach + away * stage.camera.magnification(spot.depth);
            all.extend(
                [1.0, -1.0].map(|side| [spot.px[0] + side * off * normal[0], spot.px[1] + side * off * normal[1]]),
            );
        }
    }
    all
}

/// Writes the labels of frames and legs between two heights of the picture.
pub(super) fn draw(canvas: &mut Canvas, scene: &Scene, stage: &Stage, obstacles: Vec<Obstacle>, rows: (f64, f64)) {
    let mut places = Places { canvas, obstacles, rows };
    for frame in &scene.frames {
        let Some(origin) = stage.see(&frame.origin) else { continue };
        let mut lean = [0.0, 0.0];
        for (axis, name) in frame.axes.into_iter().zip(["x", "y", "z"]) {
            let Some(head) = stage.see(&tip(frame.origin, axis, frame.length)) else { continue };
            let along = [head.px[0] - origin.px[0], head.px[1] - origin.px[1]];
            let length = along[0].hypot(along[1]);
            lean = [lean[0] + along[0] / length.max(1e-9), lean[1] + along[1] / length.max(1e-9)];
            // An axis that points to the camera or is very short has no visible direction.
            if length > 7.0 {
                places.put(&AXIS, name, around(head.px, along, half(&AXIS, name)));
            }
        }
        let label = shorten(frame.label.trim(), FRAME.size, LONGEST);
        if !label.is_empty() {
            // Opposite to the axes there is room.
            let wanted = if lean[0].hypot(lean[1]) < 1e-6 { [0.0, 1.0] } else { [-lean[0], -lean[1]] };
            places.put(&FRAME, &label, around(origin.px, wanted, half(&FRAME, &label)));
        }
    }
    for leg in &scene.legs {
        let (Some(from), Some(to)) = (stage.see(&leg.from), stage.see(&leg.to)) else { continue };
        let label = shorten(leg.label.trim(), LEG.size, LONGEST);
        if !label.is_empty() {
            places.put(&LEG, &label, beside(stage, from, to, half(&LEG, &label)));
        }
    }
    for arrow in &scene.arrows {
        let (Some(foot), Some(head)) = (stage.see(&arrow.from), stage.see(&arrow.to)) else { continue };
        let label = shorten(arrow.label.trim(), FRAME.size, LONGEST_OF_ARROW);
        if !label.is_empty() {
            let along = [head.px[0] - foot.px[0], head.px[1] - foot.px[1]];
            // Where there is no room beyond the head, the label stands beside the arrow and not on it.
            places.obstacles.push(Obstacle::new(&foot, &head, OWN));
            let half = half(&FRAME, &label);
            let part = |s: f64| [foot.px[0] + s * along[0], foot.px[1] + s * along[1]];
            let beside = [0.5, 0.0].into_iter().flat_map(|s| around(part(s), [along[1], -along[0]], half));
            places.put(&FRAME, &label, around(head.px, along, half).into_iter().chain(beside));
        }
    }
}
