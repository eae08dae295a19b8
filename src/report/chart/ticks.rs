//! Tick marks and tick labels around a plot.

use super::Axis;
use super::axis::{Extent, Tick, View};
use super::marks::Plot;
use super::number::{is_break, shorten, width, wrap};
use super::panel::{Frame, NAME, TICK, UPRIGHT};
use super::svg::{Anchor, Canvas, Font, TextBox};

/// The places of the tick marks, and whether they are long ones.
pub(super) fn marks_of(view: &View) -> impl Iterator<Item = (f64, bool)> {
    let ticks = view.ticks.iter().map(|t| (t.at, true));
    ticks.chain(view.minor.iter().map(|v| (*v, false)))
}

/// Fits the x axis with as many ticks as there is room for their labels.
pub(super) fn fit_x(axis: &Axis, extent: &Extent, plot_width: f64) -> View {
    let mut most = (plot_width / 55.0).clamp(2.0, 12.0) as usize;
    loop {
        let view = View::fit(axis, extent, most);
        let places: Vec<f64> = view.ticks.iter().map(|t| view.place(t.at) * plot_width).collect();
        let widths: Vec<f64> = view.ticks.iter().map(|t| width(&t.text, TICK.size, false)).collect();
        let fits = places.windows(2).zip(widths.windows(2)).all(|(p, w)| match (p, w) {
            ([a, b], [u, v]) => b - a >= (u + v) / 2.0 + 8.0,
            _ => true,
        });
        if fits || most <= 2 || view.named {
            return view;
        }
        most -= 1;
    }
}

/// The tick labels below the plot (places from its left edge), and whether they stand upright.
pub(super) fn labels_below(x: &View, frame: &Frame) -> (Vec<(f64, Vec<String>)>, bool) {
    let place = |at: f64| x.place(at) * frame.plot_width;
    let (low, high) = (frame.x - frame.plot_x, frame.x + frame.width - frame.plot_x);
    if x.named {
        let slot = (place(1.0) - place(0.0)).abs();
        let wrapped = |t: &Tick| {
            let at = place(t.at);
            // Half the distance to the neighbours or to the borders of the panel, whichever is nearer.
            let room = (slot - 8.0).min(2.0 * (at - low)).min(2.0 * (high - at));
            let whole = t.text.split(is_break).all(|w| width(w, TICK.size, false) <= room);
            let lines = wrap(&t.text, TICK.size, false, room);
            (whole && lines.len() <= 4).then_some((at, lines))
        };
        if let Some(all) = x.ticks.iter().map(wrapped).collect() {
            return (all, false);
        }
        let every = (16.0 / slot.max(0.01)).ceil().max(1.0) as usize;
        let short = |t: &Tick| (place(t.at), vec![shorten(&t.text, TICK.size, UPRIGHT)]);
        return (x.ticks.iter().step_by(every).map(short).collect(), true);
    }
    let mut kept: Vec<(f64, Vec<String>)> = Vec::new();
    let mut end = f64::NEG_INFINITY;
    for tick in &x.ticks {
        let half = width(&tick.text, TICK.size, false) / 2.0;
        let at = place(tick.at).min(high - half).max(low + half);
        if at - half >= end + 5.0 {
            end = at + half;
            kept.push((at, vec![tick.text.clone()]));
        }
    }
    (kept, false)
}

/// The tick labels beside the plot, thinned if there are too many.
pub(super) fn beside(canvas: &mut Canvas, plot: &Plot<'_>, anchor: Anchor) {
    let font = Font { anchor, ..TICK };
    let x = if anchor == Anchor::End { plot.left - 9.0 } else { plot.left + plot.width + 9.0 };
    let mut last: Option<TextBox> = None;
    for tick in &plot.y.ticks {
        let text = if plot.y.named { shorten(&tick.text, TICK.size, NAME) } else { tick.text.clone() };
        let y = plot.py(tick.at) + 0.28 * TICK.size;
        let own = TextBox::of(&font, x, y, &text);
        if last.as_ref().is_none_or(|l| l.y0 >= own.y1 + 1.0) {
            canvas.text(&font, x, y, &text);
            last = Some(own);
        }
    }
}
