//! The shapes of the series.

use super::axis::View;
use super::number::significant;
use super::svg::{Canvas, LIGHT, num};
use super::{Series, Shape};

/// Series with more points than this get no tooltips, and their markers become one path.
pub(super) const MANY: usize = 400;

/// Outlines of the markers, in units of the radius; the first one (no corners) is the circle.
const OUTLINES: [&[(f64, f64)]; 8] = [
    &[],
    &[(-0.88, -0.88), (0.88, -0.88), (0.88, 0.88), (-0.88, 0.88)],
    &[(0.0, -1.2), (1.15, 0.8), (-1.15, 0.8)],
    &[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)],
    &[(0.0, 1.2), (1.15, -0.8), (-1.15, -0.8)],
    &[
        (-0.4, -1.25),
        (0.4, -1.25),
        (0.4, -0.4),
        (1.25, -0.4),
        (1.25, 0.4),
        (0.4, 0.4),
        (0.4, 1.25),
        (-0.4, 1.25),
        (-0.4, 0.4),
        (-1.25, 0.4),
        (-1.25, -0.4),
        (-0.4, -0.4),
    ],
    &[
        (0.0, -0.57),
        (0.6, -1.17),
        (1.17, -0.6),
        (0.57, 0.0),
        (1.17, 0.6),
        (0.6, 1.17),
        (0.0, 0.57),
        (-0.6, 1.17),
        (-1.17, 0.6),
        (-0.57, 0.0),
        (-1.17, -0.6),
        (-0.6, -1.17),
    ],
    &[(-1.1, -1.1), (1.1, -1.1), (-1.1, 1.1), (1.1, 1.1)],
];

/// The outline of the marker of a colour as path data.
pub(super) fn marker(colour: usize, x: f64, y: f64, r: f64) -> String {
    let corners = OUTLINES.get(colour % OUTLINES.len()).copied().unwrap_or(&[]);
    if corners.is_empty() {
        let (d, r2) = (num(2.0 * r), num(r));
        return format!("M{} {}a{r2} {r2} 0 1 0 {d} 0a{r2} {r2} 0 1 0 -{d} 0z", num(x - r), num(y));
    }
    let mut d = String::new();
    for (i, (u, v)) in corners.iter().enumerate() {
        d.push_str(if i == 0 { "M" } else { "L" });
        d.push_str(&format!("{} {}", num(x + u * r), num(y + v * r)));
    }
    d.push('z');
    d
}

/// An arrow as path data: the shaft and a filled head, which is shorter on short arrows. The round caps make a dot of
/// an arrow without length.
pub(super) fn arrow(foot: [f64; 2], tip: [f64; 2], head: f64) -> String {
    let (dx, dy) = (tip[0] - foot[0], tip[1] - foot[1]);
    let length = dx.hypot(dy);
    let at = |p: [f64; 2]| format!("{} {}", tenth(p[0]), tenth(p[1]));
    if !(length > 0.3) {
        return format!("M{}h0", at(tip));
    }
    let (ux, uy) = (dx / length, dy / length);
    let head = head.min(0.55 * length);
    let neck = [tip[0] - head * ux, tip[1] - head * uy];
    let side = |s: f64| at([neck[0] - s * 0.36 * head * uy, neck[1] + s * 0.36 * head * ux]);
    format!("M{}L{}M{}L{}L{}z", at(foot), at(neck), side(1.0), at(tip), side(-1.0))
}

/// A coordinate with at most one decimal, for pictures of very many points.
pub(super) fn tenth(v: f64) -> String {
    num((v * 10.0).round() / 10.0)
}

/// The class of the markers of data points.
pub(super) fn marker_class() -> &'static str {
    "dot"
}

/// The class of a colour of the palette.
pub(super) fn palette_class(colour: usize) -> String {
    format!("c{}", colour % LIGHT.len())
}

/// The plot area with the views of its axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plot<'a> {
    pub x: &'a View,
    pub y: &'a View,
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
    /// Whether bars of several series lie over each other, and are tinted less.
    pub overlaid: bool,
}

impl Plot<'_> {
    pub(super) fn px(&self, v: f64) -> f64 {
        self.left + self.x.place(v) * self.width
    }

    pub(super) fn py(&self, v: f64) -> f64 {
        self.top + (1.0 - self.y.place(v)) * self.height
    }

    fn draws(&self, [x, y]: [f64; 2]) -> bool {
        self.x.draws(x) && self.y.draws(y)
    }

    pub(super) fn shows(&self, [x, y]: [f64; 2]) -> bool {
        self.x.contains(x) && self.y.contains(y)
    }

    /// Lower end of a bar or band: on a log axis all that is not positive is at the lower end of the axis.
    fn low(&self, v: f64) -> Option<f64> {
        if self.y.log && v.is_finite() && v <= 0.0 { Some(self.y.lo) } else { self.y.draws(v).then_some(v) }
    }

    /// Draws what must be cut at the borders of the plot: areas, bars and lines.
    pub(super) fn draw_clipped(&self, canvas: &mut Canvas, series: &Series) {
        match &series.shape {
            Shape::Band { lower } => canvas.path("band", &self.band(&series.points, lower), None),
            Shape::Bars { width } => self.bars(canvas, series, *width),
            Shape::Line | Shape::LineWithDots => canvas.path("ln", &self.line(&series.points), None),
            Shape::Dashed => canvas.path("da", &self.line(&series.points), None),
            Shape::ErrorBars { ends } => self.error_bars(canvas, series, ends),
            Shape::Cells { values } => self.cells(canvas, series, values),
            Shape::Dots | Shape::Bubbles { .. } => {}
        }
    }

    /// Draws the markers; `marked` tells whether lines bear them.
    pub(super) fn draw_markers(&self, canvas: &mut Canvas, series: &Series, marked: bool) {
        match &series.shape {
            Shape::Line | Shape::Dashed if marked => self.sparse(canvas, series),
            Shape::Dots | Shape::LineWithDots => self.dots(canvas, series, None),
            Shape::ErrorBars { ends } => self.dots(canvas, series, Some(ends)),
            Shape::Bubbles { sizes, full } => self.bubbles(canvas, series, sizes, *full),
            _ => {}
        }
    }

    fn line(&self, points: &[[f64; 2]]) -> String {
        let mut d = String::new();
        for run in points.split(|p| !self.draws(*p)) {
            for (i, [x, y]) in run.iter().enumerate() {
                d.push_str(if i == 0 { "M" } else { "L" });
                d.push_str(&format!("{} {}", num(self.px(*x)), num(self.py(*y))));
            }
            if run.len() == 1 {
                // A lonely point: the round cap makes it visible.
                d.push_str("h0");
            }
        }
        d
    }

    fn band(&self, points: &[[f64; 2]], lower: &[f64]) -> String {
        let edges: Vec<([f64; 2], Option<f64>)> =
            points.iter().zip(lower).map(|(p, low)| (*p, if self.draws(*p) { self.low(*low) } else { None })).collect();
        let mut d = String::new();
        for run in edges.split(|(_, low)| low.is_none()).filter(|r| !r.is_empty()) {
            let above = run.iter().map(|([x, y], _)| (self.px(*x), self.py(*y)));
            let below = run.iter().rev().filter_map(|([x, _], low)| Some((self.px(*x), self.py((*low)?))));
            for (i, (x, y)) in above.chain(below).enumerate() {
                d.push_str(if i == 0 { "M" } else { "L" });
                d.push_str(&format!("{} {}", num(x), num(y)));
            }
            d.push('z');
        }
        d
    }

    fn bars(&self, canvas: &mut Canvas, series: &Series, width: f64) {
        let class = if self.overlaid { "over" } else { "bar" };
        let half = if width.is_finite() { width.abs() / 2.0 } else { 0.0 };
        let mut all = String::new();
        for point in series.points.iter().filter(|p| self.draws(**p)) {
            let [x, y] = *point;
            let (mut a, mut b) = (self.px(x - half), self.px(x + half));
            if b - a < 1.0 {
                (a, b) = (self.px(x) - 0.5, self.px(x) + 0.5);
            }
            let foot = self.py(if self.y.log { self.y.lo } else { 0.0 });
            let d = format!("M{} {}H{}V{}H{}z", num(a), num(foot), num(b), num(self.py(y)), num(a));
            if series.points.len() > MANY {
                all.push_str(&d);
            } else {
                canvas.path(class, &d, Some(&self.tip(series, *point, None)));
            }
        }
        canvas.path(class, &all, None);
    }

    fn error_bars(&self, canvas: &mut Canvas, series: &Series, ends: &[[f64; 2]]) {
        let mut all = String::new();
        for (point, end) in series.points.iter().zip(ends) {
            let (Some(lo), Some(hi)) = (self.low(end[0]), self.low(end[1])) else { continue };
            if !self.draws(*point) {
                continue;
            }
            let (x, a, b) = (self.px(point[0]), num(self.py(lo)), num(self.py(hi)));
            let d = format!("M{0} {a}V{b}M{1} {a}h8M{1} {b}h8", num(x), num(x - 4.0));
            if series.points.len() > MANY {
                all.push_str(&d);
            } else {
                canvas.path("err", &d, Some(&self.tip(series, *point, Some(end))));
            }
        }
        canvas.path("err", &all, None);
    }

    fn dots(&self, canvas: &mut Canvas, series: &Series, ends: Option<&[[f64; 2]]>) {
        let many = series.points.len() > MANY;
        let radius = if many {
            2.0
        } else if series.points.len() > 100 {
            3.0
        } else {
            4.0
        };
        let mut all = String::new();
        for (i, point) in series.points.iter().enumerate().filter(|(_, p)| self.shows(**p)) {
            let d = marker(series.colour, self.px(point[0]), self.py(point[1]), radius);
            if many || series.plain {
                all.push_str(&d);
            } else {
                let end = ends.and_then(|e| e.get(i));
                canvas.path(marker_class(), &d, Some(&self.tip(series, *point, end)));
            }
        }
        canvas.path(marker_class(), &all, None);
    }

    /// A few hollow markers along a line, staggered by the colour.
    fn sparse(&self, canvas: &mut Canvas, series: &Series) {
        let shown: Vec<[f64; 2]> = series.points.iter().copied().filter(|p| self.shows(*p)).collect();
        let gap = shown.len().div_ceil(6).max(1);
        let start = gap * (1 + series.colour % OUTLINES.len()) / (OUTLINES.len() + 1);
        for point in shown.iter().skip(start.min(shown.len().saturating_sub(1))).step_by(gap) {
            let d = marker(series.colour, self.px(point[0]), self.py(point[1]), 3.4);
            let tip = (series.points.len() <= MANY).then(|| self.tip(series, *point, None));
            canvas.path("mark", &d, tip.as_deref());
        }
    }

    /// Name, x and y (and the ends of the error bar).
    fn tip(&self, series: &Series, [x, y]: [f64; 2], end: Option<&[f64; 2]>) -> String {
        let value = |view: &View, v: f64| {
            let name = view.ticks.iter().find(|t| view.named && t.at == v).map(|t| t.text.clone());
            name.unwrap_or_else(|| significant(v, 4))
        };
        let colon = if series.name.is_empty() { "" } else { ": " };
        let mut tip = format!("{}{colon}x = {}, y = {}", series.name, value(self.x, x), value(self.y, y));
        if let Some([lo, hi]) = end {
            tip.push_str(&format!(" ({} … {})", significant(*lo, 4), significant(*hi, 4)));
        }
        tip
    }
}
