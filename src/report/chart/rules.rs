//! Labelled reference lines.

use super::marks::Plot;
use super::number::{shorten, significant};
use super::svg::{Anchor, Canvas, Font, TextBox, num};
use super::{Panel, Rule, Shape};

const FONT: Font = Font::new(12.0, "h", Anchor::Start);
const AWAY: f64 = 5.0;
/// Half the size of a marker, and a little.
const MARKER: f64 = 5.0;

/// The label of rules that stands in the legend, where it hides no point: the only one of a panel with markers.
pub(super) fn legend_label(panel: &Panel) -> Option<&str> {
    let plain = |s: &Shape| matches!(s, Shape::Line | Shape::Dashed | Shape::Band { .. });
    let mut labels = panel.rules.iter().map(|r| r.label.trim()).filter(|label| !label.is_empty());
    let first = labels.next()?;
    (labels.all(|label| label == first) && panel.series.iter().any(|s| !plain(&s.shape))).then_some(first)
}

/// Draws the lines and then their labels, each at the first of the places inside the plot that are free and hide the
/// fewest markers. A label without a place (among very many lines) remains as the tooltip of its line.
pub(super) fn draw(canvas: &mut Canvas, plot: &Plot<'_>, panel: &Panel, markers: &[(f64, f64)]) {
    let rules = &panel.rules;
    let shown = |r: &&Rule| if r.horizontal { plot.y.contains(r.at) } else { plot.x.contains(r.at) };
    for rule in rules.iter().filter(shown) {
        let d = if rule.horizontal {
            format!("M{} {}h{}", num(plot.left), num(plot.py(rule.at)), num(plot.width))
        } else {
            format!("M{} {}v{}", num(plot.px(rule.at)), num(plot.top), num(plot.height))
        };
        let axis = if rule.horizontal { "y" } else { "x" };
        let tip = format!("{}: {axis} = {}", rule.label, significant(rule.at, 4));
        canvas.path("rule", &d, Some(tip.trim_start_matches(": ")));
    }
    if legend_label(panel).is_some() {
        return;
    }
    let mut taken: Vec<TextBox> = Vec::new();
    for rule in rules.iter().filter(shown) {
        let text = shorten(rule.label.trim(), FONT.size, plot.width - 2.0 * AWAY);
        if text.is_empty() {
            continue;
        }
        let free = |(x, y): &(f64, f64)| {
            let own = TextBox::of(&FONT, *x, *y, &text);
            let inside = own.x0 >= plot.left + 1.0
                && own.x1 <= plot.left + plot.width - 1.0
                && own.y0 >= plot.top + 1.0
                && own.y1 <= plot.top + plot.height - 1.0;
            inside && !taken.iter().any(|t| t.overlaps(&own))
        };
        let hidden = |(x, y): &(f64, f64)| {
            let own = TextBox::of(&FONT, *x, *y, &text);
            let (across, along) = (own.x0 - MARKER..own.x1 + MARKER, own.y0 - MARKER..own.y1 + MARKER);
            markers.iter().filter(|(u, v)| across.contains(u) && along.contains(v)).count()
        };
        let open = places(plot, rule, &text).into_iter().filter(free);
        if let Some((x, y)) = open.min_by_key(hidden) {
            canvas.text(&FONT, x, y, &text);
            taken.push(TextBox::of(&FONT, x, y, &text));
        }
    }
}

/// Candidates for the place of a label, the best ones first.
fn places(plot: &Plot<'_>, rule: &Rule, text: &str) -> Vec<(f64, f64)> {
    let own = TextBox::of(&FONT, 0.0, 0.0, text);
    let (width, up, down) = (own.x1 - own.x0, -own.y0, own.y1);
    let right = plot.left + plot.width - AWAY - width;
    let left = plot.left + AWAY;
    if rule.horizontal {
        let y = plot.py(rule.at);
        let rows = [y - AWAY - down + 2.0, y + AWAY + up - 2.0];
        let columns = (0..=8).map(|i| right + (left - right) * f64::from(i) / 8.0);
        return columns.flat_map(|x| rows.map(|y| (x, y))).collect();
    }
    let x = plot.px(rule.at);
    let sides = [x + AWAY, x - AWAY - width, (x - width / 2.0).min(right).max(left)];
    let rows = (plot.height / FONT.line()) as usize;
    let row = |i: usize| plot.top + AWAY + up + i as f64 * FONT.line();
    (0..rows).flat_map(|i| sides.map(|x| (x, row(i)))).collect()
}
