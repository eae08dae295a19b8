//! Shapes that show a third value: circles by their area, cells by their tint.

use super::Series;
use super::axis::View;
use super::marks::Plot;
use super::number::significant;
use super::svg::{Canvas, escape, num};

/// Radius of the largest circle.
const LARGEST: f64 = 13.0;
/// Radius below which a circle could not be seen.
const SMALLEST: f64 = 0.8;
/// Cells paler than this are not drawn.
const PALEST: f64 = 0.01;

impl Plot<'_> {
    /// A circle at each point; one of the size `full` has the largest radius.
    pub(super) fn bubbles(&self, canvas: &mut Canvas, series: &Series, sizes: &[f64], full: f64) {
        let mut order: Vec<(&[f64; 2], f64)> =
            series.points.iter().zip(sizes.iter().copied()).filter(|(p, s)| self.shows(**p) && s.is_finite()).collect();
        // Small circles lie over large ones.
        order.sort_by(|a, b| b.1.total_cmp(&a.1));
        for ([x, y], size) in order {
            let part = if full > 0.0 { (size.max(0.0) / full).min(1.0) } else { 0.0 };
            let r = (LARGEST * part.sqrt()).max(SMALLEST);
            let (left, d, r) = (num(self.px(*x) - r), num(2.0 * r), num(r));
            let d = format!("M{left} {}a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0 -{d} 0z", num(self.py(*y)));
            let tip = format!("x = {}, y = {}: {}", significant(*x, 3), significant(*y, 3), significant(size, 3));
            canvas.path("over", &d, Some(&tip));
        }
    }

    /// A cell of one unit by one unit at each point.
    pub(super) fn cells(&self, canvas: &mut Canvas, series: &Series, values: &[f64]) {
        for (point, value) in series.points.iter().zip(values) {
            let [x, y] = *point;
            let strength = value.min(1.0);
            if !(self.shows(*point) && strength >= PALEST) {
                continue;
            }
            let (a, b, top, bottom) = (self.px(x - 0.5), self.px(x + 0.5), self.py(y + 0.5), self.py(y - 0.5));
            let (a, w, top, h) = (num(a), num(b - a), num(top), num(bottom - top));
            let (tip, opacity) = (escape(&self.cell_tip(x, y, *value)), num(strength));
            canvas.raw(&format!(
                "<path fill=\"currentColor\" fill-opacity=\"{opacity}\" d=\"M{a} {top}h{w}v{h}h-{w}z\"><title>{tip}</title></path>\n"
            ));
        }
    }

    fn cell_tip(&self, x: f64, y: f64, value: f64) -> String {
        let name = |view: &View, at: f64| {
            view.ticks.iter().find(|t| t.at == at).map_or_else(|| significant(at, 3), |t| t.text.clone())
        };
        format!("{}, {}: {}", name(self.x, x), name(self.y, y), significant(value, 3))
    }
}
