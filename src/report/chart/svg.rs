//! The canvas: SVG elements, styles, and the record of all text boxes.

use super::number::width;

/// Palette on the light background: an Okabe-Ito variant, darkened to a contrast of at least 3:1.
pub(super) const LIGHT: [&str; 7] = ["#0069ab", "#c94f00", "#00845f", "#ad4f87", "#9a6a00", "#2f86bd", "#50565e"];
/// Palette on the dark background.
pub(super) const DARK: [&str; 7] = ["#4ea3e6", "#ff8a4c", "#2cc596", "#e59bc9", "#ecb32c", "#a3dcff", "#c3c8cf"];
/// Backgrounds, texts and faint texts: light, dark.
pub(super) const GROUND: [&str; 2] = ["#ffffff", "#14171b"];
/// Colours of the texts: light, dark.
pub(super) const INK: [&str; 2] = ["#1c2126", "#eceff2"];
/// Colours of the tick labels: light, dark.
pub(super) const FAINT: [&str; 2] = ["#4a525b", "#b9c0c8"];
const GRID: [&str; 2] = ["#e2e5e9", "#2c3238"];
const FRAME: [&str; 2] = ["#757d86", "#868f99"];

/// Where the given x of a text lies in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// How a text is set.
#[derive(Clone, Copy, Debug)]
pub(super) struct Font {
    pub size: f64,
    pub bold: bool,
    /// Class without prefix: `t` text, `m` muted, `h` with a halo.
    pub class: &'static str,
    pub anchor: Anchor,
    /// Turned to read upwards.
    pub upright: bool,
}

impl Font {
    pub(super) const fn new(size: f64, class: &'static str, anchor: Anchor) -> Self {
        Self { size, bold: false, class, anchor, upright: false }
    }

    /// Distance of two lines.
    pub(super) fn line(&self) -> f64 {
        (self.size * 1.3).ceil()
    }
}

/// The estimated place of a text.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TextBox {
    pub x0: f64,
    pub y0: f64,
    pub x1: f64,
    pub y1: f64,
    pub text: String,
}

impl TextBox {
    /// The box of a text whose baseline is at y.
    pub(super) fn of(font: &Font, x: f64, y: f64, text: &str) -> Self {
        let w = width(text, font.size, font.bold);
        let (up, down) = (0.8 * font.size, 0.24 * font.size);
        let before = match font.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => w / 2.0,
            Anchor::End => w,
        };
        let text = text.to_owned();
        if font.upright {
            Self { x0: x - up, x1: x + down, y0: y - (w - before), y1: y + before, text }
        } else {
            Self { x0: x - before, x1: x - before + w, y0: y - up, y1: y + down, text }
        }
    }

    pub(super) fn overlaps(&self, other: &Self) -> bool {
        self.x0 < other.x1 && other.x0 < self.x1 && self.y0 < other.y1 && other.y0 < self.y1
    }
}

/// The picture under construction.
#[derive(Debug)]
pub(super) struct Canvas {
    pub id: String,
    pub width: f64,
    pub height: f64,
    pub boxes: Vec<TextBox>,
    pub extra: Extra,
    body: String,
}

/// Rules of the style sheet beyond the common ones.
#[derive(Clone, Debug, Default)]
pub(super) struct Extra {
    /// For both backgrounds.
    pub common: String,
    /// For the light and for the dark background.
    pub modes: [String; 2],
}

impl Canvas {
    pub(super) fn new(id: &str, width: f64) -> Self {
        let mut id: String =
            id.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '-' }).collect();
        if !id.starts_with(|c: char| c.is_ascii_alphabetic()) {
            id.insert_str(0, "chart");
        }
        Self { id, width, height: 0.0, boxes: Vec::new(), extra: Extra::default(), body: String::new() }
    }

    /// Appends markup as it is.
    pub(super) fn raw(&mut self, markup: &str) {
        self.body.push_str(markup);
    }

    /// The class attribute for class names without prefix.
    pub(super) fn class(&self, name: &str) -> String {
        format!("class=\"{}-{name}\"", self.id)
    }

    /// A path with a class and perhaps a tooltip.
    pub(super) fn path(&mut self, class: &str, d: &str, tip: Option<&str>) {
        self.stroke(class, None, d, tip);
    }

    /// A path with a class, perhaps a width of its own (the class must not set one) and perhaps a tooltip.
    pub(super) fn stroke(&mut self, class: &str, width: Option<f64>, d: &str, tip: Option<&str>) {
        if d.is_empty() {
            return;
        }
        let class = self.class(class);
        let width = width.map(|w| format!(" stroke-width=\"{}\"", num(w))).unwrap_or_default();
        match tip {
            Some(tip) => self.raw(&format!("<path {class}{width} d=\"{d}\"><title>{}</title></path>\n", escape(tip))),
            None => self.raw(&format!("<path {class}{width} d=\"{d}\"/>\n")),
        }
    }

    /// A text with its baseline at y.
    pub(super) fn text(&mut self, font: &Font, x: f64, y: f64, text: &str) {
        if text.is_empty() {
            return;
        }
        self.boxes.push(TextBox::of(font, x, y, text));
        let anchor = match font.anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let bold = if font.bold { " font-weight=\"600\"" } else { "" };
        let (px, py) = (num(x), num(y));
        let turn = if font.upright { format!(" transform=\"rotate(-90 {px} {py})\"") } else { String::new() };
        let (class, size, text) = (self.class(font.class), num(font.size), escape(text));
        self.raw(&format!(
            "<text {class} x=\"{px}\" y=\"{py}\" font-size=\"{size}\"{anchor}{bold}{turn}>{text}</text>\n"
        ));
    }

    /// Lines of text, the first one with its upper edge at y; returns their height.
    pub(super) fn lines(&mut self, font: &Font, x: f64, y: f64, lines: &[String]) -> f64 {
        for (i, line) in lines.iter().enumerate() {
            self.text(font, x, y + font.size + i as f64 * font.line(), line);
        }
        lines.len() as f64 * font.line()
    }

    /// The complete document.
    pub(super) fn finish(&self, title: &str, description: &str) -> String {
        let (id, w, h) = (&self.id, num(self.width), num(self.height));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" id=\"{id}\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
             style=\"max-width:100%;height:auto\" role=\"img\" aria-labelledby=\"{id}-title {id}-desc\">\n\
             <title id=\"{id}-title\">{}</title>\n<desc id=\"{id}-desc\">{}</desc>\n<style>\n{}</style>\n\
             <rect {} width=\"{w}\" height=\"{h}\"/>\n{}</svg>\n",
            escape(title),
            escape(description),
            self.style(),
            self.class("bg"),
            self.body
        )
    }

    fn style(&self) -> String {
        let id = &self.id;
        let mut css = format!(
            "#{id}{{font-family:system-ui,-apple-system,\"Segoe UI\",\"DejaVu Sans\",Arial,sans-serif}}\n\
             .{id}-grid,.{id}-axis,.{id}-rule,.{id}-ln,.{id}-da{{fill:none}}\n\
             .{id}-grid,.{id}-axis{{stroke-width:1}}\n\
             .{id}-rule{{stroke-width:1.4;stroke-dasharray:2 3}}\n\
             .{id}-ln,.{id}-da{{stroke:currentColor;stroke-width:2;stroke-linejoin:round;stroke-linecap:round}}\n\
             .{id}-da{{stroke-dasharray:7 5}}\n\
             .{id}-bar{{fill:currentColor;fill-opacity:.28;stroke:currentColor;stroke-width:1}}\n\
             .{id}-over{{fill:currentColor;fill-opacity:.13;stroke:currentColor;stroke-width:.8}}\n\
             .{id}-band{{fill:currentColor;fill-opacity:.2}}\n\
             .{id}-err{{fill:none;stroke:currentColor;stroke-width:1.5}}\n\
             .{id}-dot{{fill:currentColor;stroke-width:.7}}\n\
             .{id}-mark{{stroke:currentColor;stroke-width:1.5}}\n\
             .{id}-h{{paint-order:stroke;stroke-width:4;stroke-linejoin:round}}\n"
        );
        css.push_str(&self.extra.common);
        css.push_str(&self.colours(0, &LIGHT));
        css.push_str(&self.extra.modes[0]);
        css.push_str("@media (prefers-color-scheme: dark){\n");
        css.push_str(&self.colours(1, &DARK));
        css.push_str(&self.extra.modes[1]);
        css.push_str("}\n");
        css
    }

    /// The rules that depend on the background.
    fn colours(&self, mode: usize, palette: &[&str]) -> String {
        let id = &self.id;
        let pick = |pair: [&'static str; 2]| if mode == 0 { pair[0] } else { pair[1] };
        let (ground, ink, faint, grid, frame) = (pick(GROUND), pick(INK), pick(FAINT), pick(GRID), pick(FRAME));
        let mut css = format!(
            ".{id}-bg,.{id}-mark{{fill:{ground}}}\n.{id}-dot,.{id}-h{{stroke:{ground}}}\n\
             .{id}-t,.{id}-h{{fill:{ink}}}\n.{id}-m{{fill:{faint}}}\n.{id}-grid{{stroke:{grid}}}\n\
             .{id}-axis{{stroke:{frame}}}\n.{id}-rule{{stroke:{ink}}}\n"
        );
        for (i, colour) in palette.iter().enumerate() {
            css.push_str(&format!(".{id}-c{i}{{color:{colour}}}\n"));
        }
        css
    }
}

/// A coordinate with at most two decimals.
pub(super) fn num(v: f64) -> String {
    let v = if v.is_finite() { v.clamp(-1e6, 1e6) } else { 0.0 };
    let text = format!("{v:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Text for XML: markup characters escaped, forbidden characters replaced by blanks.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\u{fffe}' | '\u{ffff}' => out.push(' '),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}
