//! Title, legend, drawing and remarks of a scene.

use std::collections::BTreeSet;
use std::fmt::Write;

use super::Scene;
use super::labels;
use super::lines::path;
use super::order::paint;
use super::shapes::{Drawing, SHADES, shade_class};
use super::stage::{Stage, unit};
use crate::report::chart::figure::{MARGIN, TITLE};
use crate::report::chart::legend::{Entry, Legend, Look};
use crate::report::chart::number::{significant, wrap};
use crate::report::chart::svg::{Anchor, Canvas, DARK, Extra, Font, GROUND, INK, LIGHT};

/// Width of the picture and greatest height of the drawing alone.
pub(super) const WHOLE: [f64; 2] = [720.0, 440.0];
/// Width and greatest height of the drawing on a wide screen.
pub(super) const WIDE: [f64; 2] = [1200.0, 520.0];
/// Width and greatest height of the drawing on a phone.
pub(super) const NARROW: [f64; 2] = [358.0, 300.0];
/// Room around the drawing for the labels.
const PAD: f64 = 18.0;
const REMARK: Font = Font::new(12.5, "m", Anchor::Start);
/// How much of the background is in the colour of the farthest things.
pub(super) const MIST: f64 = 0.42;

/// Draws the scene in this size.
pub(super) fn compose(scene: &Scene, id: &str, [width, tallest]: [f64; 2]) -> Canvas {
    let mut canvas = Canvas::new(id, width);
    let inner = width - 2.0 * MARGIN;

    let mut y = MARGIN;
    let title = canvas.lines(&TITLE, MARGIN, y, &wrap(&scene.title, TITLE.size, true, inner));
    y += title + if title > 0.0 { 6.0 } else { 0.0 };
    let legend = Legend::flow(&entries(scene), inner);
    legend.draw(&mut canvas, MARGIN, y, false);
    y += legend.height;

    let stage = Stage::new(scene, [0.0, y], [width, tallest], PAD);
    let grid: String =
        stage.ground.lines().iter().filter_map(|[a, b]| Some(path(&[stage.see(a)?, stage.see(b)?], false))).collect();
    canvas.path("grid", &grid, None);
    let drawing = Drawing::new(scene, &stage);
    canvas.extra = rules(&canvas.id, scene, &drawing);
    paint(&mut canvas, drawing.items, &drawing.faces, &stage.camera);
    labels::draw(&mut canvas, scene, &stage, drawing.obstacles, (y, y + stage.height));
    y += stage.height + 2.0;

    for text in [scale(scene, &stage), scene.note.clone()] {
        y += canvas.lines(&REMARK, MARGIN, y, &wrap(&text, REMARK.size, false, inner));
    }
    canvas.height = y + MARGIN - 4.0;
    canvas
}

/// What the grid tells about lengths.
fn scale(scene: &Scene, stage: &Stage) -> String {
    let (name, metres) = unit(scene);
    let length = |v: f64| format!("{}\u{a0}{name}", significant(v / metres, 4));
    // The height of the ground is rounded: next to the size of the squares the last digits mean nothing.
    let z = (stage.ground.z / stage.ground.step * 1e3).round() * 1e-3 * stage.ground.step;
    format!("Squares on the ground are {} wide; the ground is at z = {}.", length(stage.ground.step), length(z))
}

/// One entry for each name, with the looks of all things of that name.
fn entries(scene: &Scene) -> Vec<Entry> {
    let mut all: Vec<Entry> = Vec::new();
    let mut add = |name: &str, colour: usize, look: Look| {
        if name.trim().is_empty() {
            return;
        }
        let look = (colour % LIGHT.len(), look);
        match all.iter_mut().find(|e| e.name == name) {
            Some(entry) if entry.looks.contains(&look) => {}
            Some(entry) => entry.looks.push(look),
            None => all.push(Entry { name: name.to_owned(), looks: vec![look] }),
        }
    };
    for outline in &scene.outlines {
        if outline.filled {
            add(&outline.name, outline.colour, Look::Band);
        }
        add(&outline.name, outline.colour, if outline.thin { Look::Thin } else { Look::Line });
    }
    scene.legs.iter().for_each(|s| add(&s.name, s.colour, Look::Leg));
    scene.arrows.iter().for_each(|a| add(&a.name, a.colour, Look::Arrow));
    scene.dots.iter().for_each(|d| add(&d.name, d.colour, Look::Dots));
    all
}

/// The rules for lines in perspective, and the colours of the mist.
fn rules(id: &str, scene: &Scene, drawing: &Drawing) -> Extra {
    // Among many outlines each one is fainter.
    let thin = scene.outlines.iter().filter(|o| o.thin).count();
    let faint = (2.4 / (thin.max(1) as f64).sqrt()).clamp(0.22, 0.75);
    let common = format!(
        ".{id}-edge,.{id}-halo,.{id}-thin{{fill:none;stroke-linejoin:round}}\n\
         .{id}-edge,.{id}-thin,.{id}-arrow{{stroke:currentColor;stroke-linecap:round}}\n\
         .{id}-arrow{{fill:currentColor;stroke-linejoin:round}}\n\
         .{id}-thin{{stroke-width:1.1;stroke-opacity:{faint:.2}}}\n\
         .{id}-veil{{fill:currentColor;fill-opacity:{:.3}}}\n",
        0.2 * faint
    );
    let groups = drawing.items.iter().map(|i| i.group.as_str()).chain(drawing.faces.iter().map(|f| f.group.as_str()));
    let used: BTreeSet<&str> = groups.collect();
    let mut extra = Extra { common, ..Extra::default() };
    for (mode, palette) in [LIGHT, DARK].iter().enumerate() {
        let css = &mut extra.modes[mode];
        let _ = writeln!(css, ".{id}-halo{{stroke:{}}}\n.{id}-ink{{color:{}}}", GROUND[mode], INK[mode]);
        for (i, colour) in palette.iter().enumerate() {
            for shade in 1..SHADES {
                let class = shade_class(i, shade);
                let share = MIST * shade as f64 / (SHADES - 1) as f64;
                if used.contains(class.as_str()) {
                    let _ = writeln!(css, ".{id}-{class}{{color:{}}}", mix(colour, GROUND[mode], share));
                }
            }
        }
    }
    extra
}

/// A mixture of two colours with a share of the second one.
pub(super) fn mix(a: &str, b: &str, share: f64) -> String {
    let part = |hex: &str, i: usize| hex.get(i..i + 2).and_then(|d| u8::from_str_radix(d, 16).ok()).unwrap_or(0);
    let mixed = |i| ((1.0 - share) * f64::from(part(a, i)) + share * f64::from(part(b, i))).round() as u8;
    format!("#{:02x}{:02x}{:02x}", mixed(1), mixed(3), mixed(5))
}
