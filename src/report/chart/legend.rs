//! Legends: entries, flow layout, swatches.

use super::marks::{arrow, marker, marker_class, palette_class};
use super::number::{width, wrap};
use super::rules::legend_label;
use super::svg::{Anchor, Canvas, Font, num};
use super::{Panel, Shape};

const FONT: Font = Font::new(13.0, "t", Anchor::Start);
const SWATCH: f64 = 28.0;
const GAP: f64 = 7.0;
const BETWEEN: f64 = 20.0;

/// How a swatch represents a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Look {
    Band,
    Bars,
    Line,
    Dashed,
    LineWithDots,
    ErrorBars,
    Dots,
    Bubbles,
    /// A thin faint line.
    Thin,
    /// A thick line with a joint at each end.
    Leg,
    Arrow,
    /// The dotted line of a rule.
    Rule,
}

impl Look {
    fn of(shape: &Shape) -> Self {
        match shape {
            Shape::Line => Self::Line,
            Shape::Dashed => Self::Dashed,
            Shape::Dots => Self::Dots,
            Shape::LineWithDots => Self::LineWithDots,
            Shape::Bars { .. } | Shape::Cells { .. } => Self::Bars,
            Shape::Bubbles { .. } => Self::Bubbles,
            Shape::ErrorBars { .. } => Self::ErrorBars,
            Shape::Band { .. } => Self::Band,
        }
    }
}

/// A name with the looks of all series of that name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    pub name: String,
    pub looks: Vec<(usize, Look)>,
}

/// The legend entries of a panel, in the order of the series.
pub(super) fn entries(panel: &Panel) -> Vec<Entry> {
    let mut all: Vec<Entry> = Vec::new();
    for series in panel.series.iter().filter(|s| !s.name.trim().is_empty()) {
        let look = (series.colour, Look::of(&series.shape));
        match all.iter_mut().find(|e| e.name == series.name) {
            Some(entry) if entry.looks.contains(&look) => {}
            Some(entry) => entry.looks.push(look),
            None => all.push(Entry { name: series.name.clone(), looks: vec![look] }),
        }
    }
    if let Some(label) = legend_label(panel) {
        all.push(Entry { name: label.to_owned(), looks: vec![(0, Look::Rule)] });
    }
    all
}

/// A legend laid out for a given width.
#[derive(Clone, Debug, Default)]
pub(super) struct Legend {
    items: Vec<Item>,
    pub height: f64,
}

#[derive(Clone, Debug)]
struct Item {
    x: f64,
    y: f64,
    lines: Vec<String>,
    looks: Vec<(usize, Look)>,
}

impl Legend {
    /// Places the entries in rows that are not wider than the limit.
    pub(super) fn flow(entries: &[Entry], limit: f64) -> Self {
        let mut legend = Self::default();
        let (mut x, mut y, mut row) = (0.0, 0.0, 0.0_f64);
        for entry in entries {
            let lines = wrap(&entry.name, FONT.size, false, (limit - SWATCH - GAP).max(FONT.size));
            let text = lines.iter().map(|l| width(l, FONT.size, false)).fold(0.0, f64::max);
            let (w, h) = (SWATCH + GAP + text, lines.len() as f64 * FONT.line() + 2.0);
            if x > 0.0 && x + w > limit {
                (x, y, row) = (0.0, y + row, 0.0);
            }
            legend.items.push(Item { x, y, lines, looks: entry.looks.clone() });
            x += w + BETWEEN;
            row = row.max(h);
        }
        legend.height = y + row;
        legend
    }

    /// Draws the legend; `marked` tells whether lines bear markers.
    pub(super) fn draw(&self, canvas: &mut Canvas, x: f64, y: f64, marked: bool) {
        for item in &self.items {
            let (x, y) = (x + item.x, y + item.y);
            for look in &item.looks {
                swatch(canvas, *look, x, y + 0.68 * FONT.size, marked);
            }
            canvas.lines(&FONT, x + SWATCH + GAP, y, &item.lines);
        }
    }
}

/// A sample of a shape, 28 wide around the height y.
fn swatch(canvas: &mut Canvas, (colour, look): (usize, Look), x: f64, y: f64, marked: bool) {
    let open = format!("<g {}>\n", canvas.class(&palette_class(colour)));
    canvas.raw(&open);
    let middle = x + SWATCH / 2.0;
    let rect = |up: f64| format!("M{} {}h{}v{}h{}z", num(x + 2.0), num(y - up), SWATCH - 4.0, 2.0 * up, 4.0 - SWATCH);
    let line = format!("M{} {}h{}", num(x + 1.0), num(y), SWATCH - 2.0);
    let mark = |r: f64| marker(colour, middle, y, r);
    match look {
        Look::Band => canvas.path("band", &rect(6.0), None),
        Look::Bars => canvas.path("bar", &rect(5.0), None),
        Look::Line | Look::Dashed => {
            canvas.path(if look == Look::Line { "ln" } else { "da" }, &line, None);
            if marked {
                canvas.path("mark", &mark(3.4), None);
            }
        }
        Look::LineWithDots => {
            canvas.path("ln", &line, None);
            canvas.path(marker_class(), &mark(4.2), None);
        }
        Look::ErrorBars => {
            let bar =
                format!("M{0} {1}v14M{2} {1}h6M{2} {3}h6", num(middle), num(y - 7.0), num(middle - 3.0), num(y + 7.0));
            canvas.path("err", &bar, None);
            canvas.path(marker_class(), &mark(4.0), None);
        }
        Look::Dots => canvas.path(marker_class(), &mark(4.2), None),
        Look::Bubbles => canvas.path("over", &marker(0, middle, y, 6.0), None),
        Look::Rule => canvas.path("rule", &line, None),
        Look::Thin => canvas.stroke("edge", Some(1.1), &line, None),
        Look::Leg => {
            canvas.stroke("edge", Some(4.0), &format!("M{} {}h{}", num(x + 4.0), num(y), SWATCH - 8.0), None);
            canvas.path("mark", &(marker(0, x + 4.0, y, 3.2) + &marker(0, x + SWATCH - 4.0, y, 3.2)), None);
        }
        Look::Arrow => {
            let (foot, tip) = ([x + 2.0, y], [x + SWATCH - 2.0, y]);
            canvas.stroke("arrow", Some(1.6), &arrow(foot, tip, 8.0), None);
        }
    }
    canvas.raw("</g>\n");
}
