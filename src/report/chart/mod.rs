//! Charts as self-contained SVG.
//!
//! A [`Figure`] is one picture of one or more [`Panel`]s. Each panel has an x axis, a y axis and, if wanted, a second
//! y axis on the right; on these it draws [`Series`] (lines, dots, bars, error bars, bands) and labelled reference
//! lines ([`Rule`]). A [`Scene`] is a drawing of a mechanism in perspective: rings and platforms, legs, coordinate
//! systems, and arrows for what happens to them. The text of the picture is returned as a string, to be stored as a
//! file or put into a page.
//!
//! Design rules:
//!
//! * **Nothing is hidden by accident.**  All texts are laid out with a generous estimate of their widths: titles,
//!   legends and axis labels wrap, tick labels are thinned until they fit. No text runs out of the picture or over
//!   another one.
//! * **Not by colour alone.**  The palette is safe for colour-blind readers and has sufficient contrast on the light
//!   and on the dark background; in addition the series differ by the shape of their markers. Filled markers are data
//!   points, hollow ones only tell lines apart.
//! * **Any data gives a picture.**  Values that cannot be drawn (not finite, beyond 1e300, not positive on a log axis)
//!   are left out and interrupt a line; empty, constant or single data get a sensible range around them.
//! * **Output is deterministic to the byte.**  There is no randomness, no clock and no hash map.
//! * **Several pictures live on one page.**  All ids and class names carry a prefix.

mod axis;
mod extent;
mod figure;
mod legend;
mod marks;
mod number;
mod panel;
mod rules;
mod scene;
mod svg;
#[cfg(test)]
mod tests;
mod ticks;
mod tinted;

pub use scene::{Arrow, Dot, LineSegment, Scene, Silhouette, Triad, View};

/// One picture of one or more panels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figure {
    /// Heading, drawn above the panels.
    pub title: String,
    /// Text alternative: what is seen, in a sentence or two.
    pub description: String,
    /// Panels per row; fewer are used if the panels would become too narrow.
    pub columns: usize,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
}

impl Figure {
    /// The picture as SVG text. The prefix of its ids is derived from the content.
    #[must_use]
    pub fn svg(&self) -> String {
        self.svg_with_id(&figure::default_id(self))
    }

    /// The picture as SVG text, with an id prefix that keeps the ids of several inline figures on one page apart.
    ///
    /// Characters of the prefix that are not allowed in a style sheet are replaced by `-`.
    #[must_use]
    pub fn svg_with_id(&self, id: &str) -> String {
        figure::compose(self, id).finish(&self.title, &self.description)
    }

    /// The picture for a page: the whole one for wide screens, and for narrow ones and for paper its panels one by one,
    /// at a size at which their texts can still be read; a picture of a single column is drawn once more as wide as a wide
    /// screen. [`PAGE_STYLE`] shows the one that fits.
    #[must_use]
    pub fn html_with_id(&self, id: &str) -> String {
        let whole = figure::compose(self, id);
        let alone = whole.width < figure::WIDE;
        let few = if alone { " few" } else { "" };
        let mut html = String::new();
        if alone {
            let wide = figure::compose_wide(self, &format!("{id}-wide")).finish(&self.title, &self.description);
            html.push_str(&format!("<div class=\"full\">{wide}</div>"));
        }
        let middle = if alone { " middle" } else { "" };
        let drawn = whole.finish(&self.title, &self.description);
        html.push_str(&format!("<div class=\"whole{few}{middle}\">{drawn}</div>"));
        html.push_str(&format!("<div class=\"panels{few}\">"));
        if !self.title.is_empty() {
            html.push_str(&format!("<p><strong>{}</strong></p>", svg::escape(&self.title)));
        }
        for (k, panel) in self.panels.iter().enumerate() {
            let title =
                [self.title.as_str(), panel.title.as_str()].join(if panel.title.is_empty() { "" } else { ": " });
            let own = Self { panels: vec![panel.clone()], ..Self::default() };
            let drawn = figure::compose_narrow(&own, &format!("{id}-{k}")).finish(&title, &self.description);
            html.push_str(&format!("<div>{drawn}</div>"));
        }
        html.push_str("</div>");
        html
    }
}

/// Style sheet for pages with figures from [`Figure::html_with_id`]. The widths are those from which on the texts
/// of a picture, which shrinks with the page, have nine pixels or more.
pub const PAGE_STYLE: &str = "\
.full,.whole{display:none}.panels{display:flex;flex-wrap:wrap;gap:.5rem 1rem}.panels>p{flex:1 0 100%;margin:0}
.panels>div{flex:1 1 320px;max-width:540px}.panels svg{width:100%}
@media(min-width:44rem){.whole.few{display:block}.panels.few{display:none}}
@media(min-width:60rem){.whole{display:block}.panels{display:none}.full{display:block}.whole.middle{display:none}}
";

/// One coordinate system with its series.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// Heading of the panel; may be empty.
    pub title: String,
    /// The axis below.
    pub x: Axis,
    /// The axis on the left.
    pub y: Axis,
    /// A second y axis, on the right.
    pub right: Option<Axis>,
    /// Series to draw.
    pub series: Vec<Series>,
    /// Labelled reference lines.
    pub rules: Vec<Rule>,
}

/// An axis: label, scale and range.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// Label with the unit.
    pub label: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// The range shown; without it the range of the data, padded to nice ticks.
    pub range: Option<(f64, f64)>,
    /// Values that a range of the data takes in besides, so that several panels can have the same one.
    pub besides: Option<(f64, f64)>,
    /// Names of categories at 0, 1, 2, …, shown in place of numbers if there are any.
    pub names: Vec<String>,
}

impl Axis {
    /// A linear axis over the range of the data.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), ..Self::default() }
    }

    /// A logarithmic axis over the range of the data.
    pub fn log(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Log, ..Self::default() }
    }

    /// An axis of categories at 0, 1, 2, ….
    pub fn named(label: impl Into<String>, names: Vec<String>) -> Self {
        Self { label: label.into(), names, ..Self::default() }
    }
}

/// How values are placed along an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences are equal lengths.
    #[default]
    Linear,
    /// Equal ratios are equal lengths.
    Log,
}

/// A row of points with a name, a colour and a shape.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Name in the legend; without a name it is not in the legend. Series of the same name share one entry.
    pub name: String,
    /// Index into the palette (cyclic); it selects the shape of the markers as well.
    pub colour: usize,
    /// How the points are drawn.
    pub shape: Shape,
    /// The points, x and y.
    pub points: Vec<[f64; 2]>,
    /// Whether y belongs to the axis on the right.
    pub right: bool,
    /// Whether dots bear no tooltips, so that pages with many of them stay small.
    pub plain: bool,
}

impl Series {
    /// A series on the left axis.
    pub fn new(name: impl Into<String>, colour: usize, shape: Shape, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.into(), colour, shape, points, right: false, plain: false }
    }
}

/// How the points of a series are drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Shape {
    /// A solid line; among several lines it bears a few hollow markers.
    #[default]
    Line,
    /// A dashed line; among several lines it bears a few hollow markers.
    Dashed,
    /// A marker at each point.
    Dots,
    /// A line with a marker at each point.
    LineWithDots,
    /// Bars from zero (on a log axis: from the lower end) to y, centred on x.
    Bars {
        /// Width in units of x.
        width: f64,
    },
    /// A marker at each point with a vertical bar.
    ErrorBars {
        /// Lower and upper y for each point.
        ends: Vec<[f64; 2]>,
    },
    /// A tinted area; the points give its upper edge.
    Band {
        /// Lower y for each point.
        lower: Vec<f64>,
    },
    /// A circle at each point; its area is a third value.
    Bubbles {
        /// The value of each point.
        sizes: Vec<f64>,
        /// The value of the largest circle.
        full: f64,
    },
    /// A cell of one unit by one unit at each point, tinted by a third value: a matrix on named axes.
    Cells {
        /// The value of each cell, from 0 (not drawn) to 1.
        values: Vec<f64>,
    },
}

/// A labelled reference line across the panel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rule {
    /// Whether it runs horizontally (at a value of the left y axis) or vertically (at a value of x).
    pub horizontal: bool,
    /// Its value on the axis.
    pub at: f64,
    /// Short label beside the line.
    pub label: String,
}
