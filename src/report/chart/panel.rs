//! Layout and drawing of a panel.

use super::axis::View;
use super::extent::{on_right, x_extent, y_extent};
use super::legend::{Entry, Legend};
use super::marks::{Plot, palette_class};
use super::number::{width, wrap};
use super::svg::{Anchor, Canvas, Font, num};
use super::ticks::{beside, fit_x, labels_below, marks_of};
use super::{Panel, Series, Shape, rules};

const TITLE: Font = Font { bold: true, ..Font::new(15.0, "t", Anchor::Start) };
const LABEL: Font = Font::new(13.0, "t", Anchor::Start);
/// Font of the tick labels.
pub(super) const TICK: Font = Font::new(12.0, "m", Anchor::Middle);
/// Longest names of categories beside a y axis.
pub(super) const NAME: f64 = 150.0;
/// Longest upright names of categories below an x axis.
pub(super) const UPRIGHT: f64 = 280.0;

/// The y axes of a panel and the room their tick labels need.
#[derive(Debug)]
pub(super) struct Sides {
    y: View,
    right: Option<View>,
    pub room: (f64, f64),
}

impl Sides {
    pub(super) fn new(panel: &Panel, height: f64) -> Self {
        let most = (height / 42.0) as usize;
        let y = View::fit(&panel.y, &y_extent(panel, &panel.y, false), most);
        let right = panel.right.as_ref().map(|axis| View::fit(axis, &y_extent(panel, axis, true), most));
        let room = |view: &View| {
            let widest = view.ticks.iter().map(|t| width(&t.text, TICK.size, false)).fold(0.0, f64::max);
            16.0 + if view.named { widest.min(NAME) } else { widest }
        };
        let both = (room(&y), right.as_ref().map_or(20.0, room));
        Self { y, right, room: both }
    }
}

/// A horizontal stretch of a panel: its left edge and width, and those of its plot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub x: f64,
    pub width: f64,
    pub plot_x: f64,
    pub plot_width: f64,
}

/// A panel laid out for its frame.
#[derive(Debug)]
pub(super) struct Layout<'a> {
    panel: &'a Panel,
    frame: Frame,
    sides: Sides,
    x: View,
    title: Vec<String>,
    legend: Legend,
    labels: [Vec<String>; 3],
    /// Tick labels below: place, lines.
    below: Vec<(f64, Vec<String>)>,
    upright: bool,
    empty: bool,
}

impl<'a> Layout<'a> {
    pub(super) fn new(panel: &'a Panel, frame: Frame, sides: Sides, legend: &[Entry]) -> Self {
        let extent = x_extent(panel);
        let x = fit_x(&panel.x, &extent, frame.plot_width);
        let half = if sides.right.is_some() { (frame.width - 14.0) / 2.0 } else { frame.width };
        let label = |text: &str, limit: f64| wrap(text, LABEL.size, false, limit);
        let right = sides.right.as_ref().map_or_else(Vec::new, |view| label(&view.label, half));
        let labels = [label(&sides.y.label, half), right, label(&x.label, frame.width)];
        let title = wrap(&panel.title, TITLE.size, true, frame.width);
        let legend = Legend::flow(legend, frame.width);
        let views = |s: &Series| if on_right(panel, s) { sides.right.as_ref().unwrap_or(&sides.y) } else { &sides.y };
        let drawn = |s: &Series| s.points.iter().any(|[u, v]| x.draws(*u) && views(s).draws(*v));
        let empty = panel.rules.is_empty() && !panel.series.iter().any(drawn);
        let (below, upright) = labels_below(&x, &frame);
        Self { panel, frame, sides, x, title, legend, labels, below, upright, empty }
    }

    /// Height of all that is above the plot.
    pub(super) fn header(&self) -> f64 {
        let title = self.title.len() as f64 * TITLE.line() + if self.title.is_empty() { 0.0 } else { 4.0 };
        let legend = self.legend.height + if self.legend.height > 0.0 { 6.0 } else { 0.0 };
        title + legend + self.label_height() + 10.0
    }

    fn label_height(&self) -> f64 {
        self.labels[0].len().max(self.labels[1].len()) as f64 * LABEL.line()
    }

    fn tick_height(&self) -> f64 {
        let lines = self.below.iter().map(|(_, lines)| lines.len()).max().unwrap_or(0) as f64;
        let widest = self.below.iter().flat_map(|(_, l)| l).map(|l| width(l, TICK.size, false)).fold(0.0, f64::max);
        12.0 + if self.upright { widest } else { lines * TICK.line() }
    }

    /// Height of all that is below the plot.
    pub(super) fn footer(&self) -> f64 {
        self.tick_height() + 2.0 + self.labels[2].len() as f64 * LABEL.line()
    }

    /// Draws the panel; `top` is its upper edge, `header` the height above its plot in this row.
    pub(super) fn draw(&self, canvas: &mut Canvas, top: f64, header: f64, height: f64, marked: bool) {
        let Frame { x, width: w, plot_x, plot_width } = self.frame;
        let title = canvas.lines(&TITLE, x, top, &self.title);
        self.legend.draw(canvas, x, top + title + if title > 0.0 { 4.0 } else { 0.0 }, marked);
        let plot_y = top + header;
        let label_y = |lines: &[String]| plot_y - 10.0 - lines.len() as f64 * LABEL.line();
        canvas.lines(&LABEL, x, label_y(&self.labels[0]), &self.labels[0]);
        let end = Font { anchor: Anchor::End, ..LABEL };
        canvas.lines(&end, x + w, label_y(&self.labels[1]), &self.labels[1]);

        let overlaid = self.panel.series.iter().filter(|s| matches!(s.shape, Shape::Bars { .. })).count() > 1;
        let (view, left) = (&self.sides.y, plot_x);
        let plot = Plot { x: &self.x, y: view, left, top: plot_y, width: plot_width, height, overlaid };
        self.grid(canvas, &plot);
        self.marks(canvas, &plot, marked);
        canvas.path("axis", &self.frame_lines(&plot), None);
        rules::draw(canvas, &plot, self.panel, &self.markers(&plot));
        if self.empty {
            canvas.text(&TICK, plot_x + plot_width / 2.0, plot_y + height / 2.0, "no data");
        }
        beside(canvas, &plot, Anchor::End);
        if let Some(right) = &self.sides.right {
            beside(canvas, &Plot { y: right, ..plot }, Anchor::Start);
        }
        self.below(canvas, &plot);
        let centre = Font { anchor: Anchor::Middle, ..LABEL };
        let longest = self.labels[2].iter().map(|l| width(l, LABEL.size, false)).fold(0.0, f64::max);
        let middle = (plot_x + plot_width / 2.0).min(x + w - longest / 2.0).max(x + longest / 2.0);
        canvas.lines(&centre, middle, plot_y + height + self.tick_height() + 2.0, &self.labels[2]);
    }

    fn grid(&self, canvas: &mut Canvas, plot: &Plot<'_>) {
        let mut d = String::new();
        for tick in plot.y.ticks.iter().filter(|_| !plot.y.named) {
            d.push_str(&format!("M{} {}h{}", num(plot.left), num(plot.py(tick.at)), num(plot.width)));
        }
        for tick in plot.x.ticks.iter().filter(|_| !plot.x.named) {
            d.push_str(&format!("M{} {}v{}", num(plot.px(tick.at)), num(plot.top), num(plot.height)));
        }
        canvas.path("grid", &d, None);
    }

    fn marks(&self, canvas: &mut Canvas, plot: &Plot<'_>, marked: bool) {
        let clip = format!("{}-clip{}", canvas.id, canvas.boxes.len());
        let (x, y, w, h) = (num(plot.left), num(plot.top), num(plot.width), num(plot.height));
        canvas.raw(&format!(
            "<clipPath id=\"{clip}\"><rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"/></clipPath>\n"
        ));
        let mut ordered: Vec<&Series> = self.panel.series.iter().collect();
        ordered.sort_by_key(|s| match s.shape {
            Shape::Band { .. } | Shape::Cells { .. } => 0,
            Shape::Bars { .. } => 1,
            Shape::Line | Shape::Dashed | Shape::LineWithDots => 2,
            Shape::ErrorBars { .. } => 3,
            Shape::Dots | Shape::Bubbles { .. } => 4,
        });
        for clipped in [true, false] {
            if clipped {
                canvas.raw(&format!("<g clip-path=\"url(#{clip})\">\n"));
            }
            for series in &ordered {
                let y = if on_right(self.panel, series) { self.sides.right.as_ref() } else { None };
                let plot = Plot { y: y.unwrap_or(plot.y), ..*plot };
                let open = format!("<g {}>\n", canvas.class(&palette_class(series.colour)));
                canvas.raw(&open);
                if clipped {
                    plot.draw_clipped(canvas, series);
                } else {
                    plot.draw_markers(canvas, series, marked);
                }
                canvas.raw("</g>\n");
            }
            if clipped {
                canvas.raw("</g>\n");
            }
        }
    }

    /// The places of the markers of data, and of the upper edges of bars.
    fn markers(&self, plot: &Plot<'_>) -> Vec<(f64, f64)> {
        let places = |s: &Series| {
            let y = if on_right(self.panel, s) { self.sides.right.as_ref() } else { None };
            let plot = Plot { y: y.unwrap_or(plot.y), ..*plot };
            let across: &[f64] = match s.shape {
                Shape::Bars { width } => &[-0.5 * width, 0.0, 0.5 * width],
                Shape::Dots | Shape::LineWithDots | Shape::ErrorBars { .. } | Shape::Bubbles { .. } => &[0.0],
                Shape::Line | Shape::Dashed | Shape::Band { .. } | Shape::Cells { .. } => &[],
            };
            let of = |[x, y]: &[f64; 2]| across.iter().map(|d| (plot.px(x + d), plot.py(*y))).collect::<Vec<_>>();
            s.points.iter().flat_map(of).collect::<Vec<_>>()
        };
        self.panel.series.iter().flat_map(places).collect()
    }

    /// The axes with their tick marks, and the zero line of bars.
    fn frame_lines(&self, plot: &Plot<'_>) -> String {
        let (right, bottom) = (plot.left + plot.width, plot.top + plot.height);
        let mut d = format!("M{0} {1}V{2}H{3}", num(plot.left), num(plot.top), num(bottom), num(right));
        for (at, long) in marks_of(plot.x) {
            d.push_str(&format!("M{} {}v{}", num(plot.px(at)), num(bottom), if long { 5 } else { 3 }));
        }
        for (at, long) in marks_of(plot.y) {
            d.push_str(&format!("M{} {}h-{}", num(plot.left), num(plot.py(at)), if long { 5 } else { 3 }));
        }
        let bars = |right: bool| {
            let own = |s: &&Series| on_right(self.panel, s) == right;
            self.panel.series.iter().filter(own).any(|s| matches!(s.shape, Shape::Bars { .. }))
        };
        if bars(false) && !plot.y.log && plot.y.contains(0.0) {
            d.push_str(&format!("M{} {}h{}", num(plot.left), num(plot.py(0.0)), num(plot.width)));
        }
        if let Some(view) = &self.sides.right {
            let plot = Plot { y: view, ..*plot };
            d.push_str(&format!("M{} {}V{}", num(right), num(plot.top), num(bottom)));
            for (at, long) in marks_of(view) {
                d.push_str(&format!("M{} {}h{}", num(right), num(plot.py(at)), if long { 5 } else { 3 }));
            }
            if bars(true) && !view.log && view.contains(0.0) {
                d.push_str(&format!("M{} {}h{}", num(plot.left), num(plot.py(0.0)), num(plot.width)));
            }
        }
        d
    }

    fn below(&self, canvas: &mut Canvas, plot: &Plot<'_>) {
        let top = plot.top + plot.height + 9.0;
        for (at, lines) in &self.below {
            if self.upright {
                let font = Font { upright: true, anchor: Anchor::End, ..TICK };
                for line in lines {
                    canvas.text(&font, plot.left + at + 0.3 * TICK.size, top, line);
                }
            } else {
                canvas.lines(&TICK, plot.left + at, top, lines);
            }
        }
    }
}
