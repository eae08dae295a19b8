//! Tests of ticks, texts, layout and robustness.

use std::fmt::Debug;

use super::axis::{Extent, View, label_linear, multiples, nice_step};
use super::number::{exponent, fixed, shorten, significant, superscript, ten, width, wrap};
use super::svg::{Canvas, DARK, FAINT, GROUND, INK, LIGHT, escape, num};
use super::{Axis, Figure, Panel, Rule, Scale, Series, Shape, figure};

/// Checks that all tags are balanced, attributes quoted and entities known.
fn check_xml(text: &str) {
    let mut stack: Vec<&str> = Vec::new();
    let mut rest = text;
    let mut roots = 0;
    while let Some(start) = rest.find('<') {
        check_text(&rest[..start]);
        let end = start + rest[start..].find('>').expect("open tag");
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(stack.pop(), Some(name));
            continue;
        }
        let (tag, closed) = tag.strip_suffix('/').map_or((tag, false), |t| (t, true));
        let (name, attributes) = tag.split_once(' ').unwrap_or((tag, ""));
        assert!(!name.is_empty() && name.chars().all(|c| c.is_ascii_alphabetic()), "{name}");
        let parts: Vec<&str> = attributes.split('"').collect();
        assert_eq!(parts.len() % 2, 1, "{tag}");
        let mut seen = Vec::new();
        for pair in parts.chunks(2).filter(|p| p.len() == 2) {
            let key = pair[0].trim().strip_suffix('=').expect("attribute");
            assert!(!seen.contains(&key), "{tag}");
            seen.push(key);
            check_text(pair[1]);
            if ["d", "x", "y", "width", "height", "viewBox"].contains(&key) {
                check_numbers(pair[1]);
            }
        }
        roots += usize::from(stack.is_empty());
        if !closed {
            stack.push(name);
        }
    }
    assert!(stack.is_empty() && rest.trim().is_empty() && roots == 1);
}

fn check_text(text: &str) {
    assert!(!text.contains(|c: char| c == '<' || (c.is_control() && c != '\n')), "{text}");
    for entity in text.split('&').skip(1) {
        assert!(["amp;", "lt;", "gt;", "quot;", "#39;"].iter().any(|e| entity.starts_with(e)), "{text}");
    }
}

fn check_numbers(text: &str) {
    for fraction in text.split('.').skip(1) {
        assert!(fraction.bytes().take_while(u8::is_ascii_digit).count() <= 2, "{text}");
    }
}

fn check(figure: &Figure, id: &str) {
    let text = figure.svg_with_id(id);
    assert_eq!(text, figure.svg_with_id(id));
    check_xml(&format!("<figure>{}</figure>", figure.html_with_id(id)));
    check_picture(&figure::compose(figure, id), &text, figure);
    check_picture(&figure::compose_narrow(figure, id), &text, figure);
}

/// Checks the markup of a picture, and that its texts lie inside and not over each other.
pub(super) fn check_picture(canvas: &Canvas, text: &str, figure: &impl Debug) {
    check_xml(text);
    assert!(!text.contains("NaN") && !text.contains("inf"), "{figure:?}");
    for (i, a) in canvas.boxes.iter().enumerate() {
        let inside = a.x0 >= 0.0 && a.y0 >= 0.0 && a.x1 <= canvas.width && a.y1 <= canvas.height;
        assert!(inside, "{a:?} is outside {} x {}: {figure:?}", canvas.width, canvas.height);
        for b in &canvas.boxes[i + 1..] {
            assert!(!a.overlaps(b), "{a:?} overlaps {b:?}: {figure:?}");
        }
    }
}

/// Pseudo-random numbers.
pub(super) struct Dice(pub u64);

impl Dice {
    pub(super) fn roll(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n
    }

    pub(super) fn value(&mut self, kind: usize) -> f64 {
        let unit = self.roll(1 << 20) as f64 / f64::from(1 << 20);
        let nasty = [
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            0.0,
            -0.0,
            f64::MAX,
            f64::MIN,
            f64::MIN_POSITIVE,
            5e-324,
            1e-300,
            -1e-295,
            1e300,
            -9.9e299,
            1.0,
            -1.0,
            1e-9,
            123_456.789,
        ];
        match kind {
            0 => nasty[self.roll(nasty.len())],
            1 => (unit - 0.5) * ten(self.roll(600) as i32 - 300),
            2 => 1e9 + 1e-6 * unit,
            3 => 3.0 + unit,
            4 => 4.25,
            _ => (self.roll(8) as f64) - 1.0,
        }
    }

    pub(super) fn text(&mut self) -> String {
        let words =
            ["leg", "W", "<b>&amp;", "\"q\"", "\u{1}\t", "Überbestimmtheit", "誤差", "(m/s²)", "🙂", "]]>", "1e-3"];
        let long = [0, 1, 2, 4, 9, 40][self.roll(6)];
        let glue = if self.roll(9) == 0 { "" } else { " " };
        (0..long).map(|_| words[self.roll(words.len())]).collect::<Vec<_>>().join(glue)
    }

    fn axis(&mut self, kind: usize) -> Axis {
        let scale = if self.roll(2) == 0 { Scale::Linear } else { Scale::Log };
        let range = (self.roll(3) == 0).then(|| (self.value(kind), self.value(kind)));
        let count = if self.roll(4) == 0 { self.roll(70) } else { 0 };
        let (label, names) = (self.text(), (0..count).map(|_| self.text()).collect());
        Axis { label, scale, range, besides: None, names }
    }

    fn series(&mut self, kinds: (usize, usize)) -> Series {
        let count = [0, 1, 2, 5, 30, 450][self.roll(6)];
        let points: Vec<[f64; 2]> = (0..count).map(|_| [self.value(kinds.0), self.value(kinds.1)]).collect();
        let shape = match self.roll(7) {
            0 => Shape::Line,
            1 => Shape::Dashed,
            2 => Shape::Dots,
            3 => Shape::LineWithDots,
            4 => Shape::Bars { width: self.value(kinds.0) },
            5 => Shape::ErrorBars { ends: (0..count / 2).map(|_| [self.value(kinds.1), self.value(0)]).collect() },
            _ => Shape::Band { lower: (0..count + 3).map(|_| self.value(kinds.1)).collect() },
        };
        Series { right: self.roll(3) == 0, ..Series::new(self.text(), self.roll(1000), shape, points) }
    }

    fn panel(&mut self) -> Panel {
        let kinds = (self.roll(6), self.roll(6));
        let rules = (0..[0, 0, 3, 40][self.roll(4)])
            .map(|_| Rule { horizontal: self.roll(2) == 0, at: self.value(kinds.1), label: self.text() })
            .collect();
        Panel {
            title: self.text(),
            x: self.axis(kinds.0),
            y: self.axis(kinds.1),
            right: (self.roll(3) == 0).then(|| self.axis(kinds.1)),
            series: (0..self.roll(5)).map(|_| self.series(kinds)).collect(),
            rules,
        }
    }
}

#[test]
fn nasty_data_gives_sound_pictures() {
    let mut dice = Dice(11);
    for _ in 0..120 {
        let panels = (0..dice.roll(5)).map(|_| dice.panel()).collect();
        let columns = dice.roll(6);
        let figure = Figure { title: dice.text(), description: dice.text(), columns, panels };
        check(&figure, "n");
    }
    check(&Figure::default(), "");
    check(&Figure { columns: usize::MAX, panels: vec![Panel::default(); 9], ..Figure::default() }, "9 ü");
}

#[test]
fn steps_are_nice() {
    for (raw, step, e) in
        [(0.9, 1.0, 0), (1.0, 1.0, 0), (1.1, 2.0, 0), (3.0, 5.0, 0), (6.0, 10.0, 1), (0.0003, 5e-4, -4)]
    {
        let (s, k) = nice_step(raw);
        assert!((s / step - 1.0).abs() < 1e-12 && k == e, "{raw}: {s} {k}");
    }
    assert_eq!(multiples(-0.1, 0.3, 0.1).len(), 5);
    assert_eq!(exponent(1000.0), 3);
    assert_eq!(exponent(999.9), 2);
    assert_eq!(exponent(1e-5), -5);
}

fn labels(axis: &Axis, values: &[f64]) -> (Vec<String>, String) {
    let mut extent = Extent::new(axis);
    values.iter().for_each(|v| extent.add(*v));
    let view = View::fit(axis, &extent, 6);
    (view.ticks.into_iter().map(|t| t.text).collect(), view.label)
}

#[test]
fn linear_labels_are_short() {
    let axis = Axis::linear("error (m)");
    let (ticks, label) = labels(&axis, &[0.0, 0.034]);
    assert_eq!((ticks[1].as_str(), label.as_str()), ("0.01", "error (m)"));
    let (ticks, label) = labels(&axis, &[0.0, 2.46e-4]);
    assert_eq!(ticks, ["0.0", "0.5", "1.0", "1.5", "2.0", "2.5"]);
    assert_eq!(label, "error (m) ×10⁻⁴");
    let (ticks, label) = labels(&axis, &[-3e7, 3e7]);
    assert_eq!((ticks[0].as_str(), label.as_str()), ("−3", "error (m) ×10⁷"));
    assert_eq!(label_linear(&[0.0], 0).0[0].text, "0");
    for data in [&[][..], &[0.0], &[5.0], &[f64::NAN, 1e300, -1e300], &[1e-320]] {
        let (ticks, _) = labels(&axis, data);
        assert!((2..=9).contains(&ticks.len()), "{data:?}: {ticks:?}");
    }
}

#[test]
fn log_labels_are_decades_or_125() {
    let axis = Axis::log("e");
    assert_eq!(labels(&axis, &[1e-5, 0.1]).0, ["10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "10⁻¹"]);
    assert_eq!(labels(&axis, &[1.0, 1000.0]).0, ["1", "10", "100", "1000"]);
    assert_eq!(labels(&axis, &[1.3, 17.0]).0, ["1", "2", "5", "10", "20"]);
    assert_eq!(labels(&axis, &[3.1e-6, 9e-6]).0[0], "2×10⁻⁶");
    let narrow = Axis { range: Some((3.1, 3.4)), ..axis.clone() };
    assert_eq!(labels(&narrow, &[]).0, ["3.1", "3.2", "3.3", "3.4"]);
    for data in [&[][..], &[0.0, -1.0], &[5.0], &[1e-280, 1e300], &[1.0, 1.0 + 1e-9]] {
        let (ticks, _) = labels(&axis, data);
        assert!((2..=10).contains(&ticks.len()), "{data:?}: {ticks:?}");
    }
}

#[test]
fn numbers_are_written_well() {
    assert_eq!(fixed(-0.001, 2), "0.00");
    assert_eq!(fixed(-1234567.5, 1), "−1\u{202f}234\u{202f}567.5");
    assert_eq!(superscript(-120), "⁻¹²⁰");
    assert_eq!(significant(0.034, 4), "0.034");
    assert_eq!(significant(9.99999, 4), "10");
    assert_eq!(significant(-2.46e-4, 4), "−2.46×10⁻⁴");
    assert_eq!(significant(123456.0, 4), "123\u{202f}500");
    assert_eq!(significant(f64::NAN, 4), "–");
    assert!(significant(f64::MAX, 4).starts_with("1.798×10"));
    assert_eq!((num(-0.001), num(1.0 / 3.0), num(f64::NAN)), ("0".into(), "0.33".into(), "0".into()));
}

#[test]
fn texts_are_escaped_and_wrapped() {
    assert_eq!(escape("<a href=\"x\">&'\u{0}"), "&lt;a href=&quot;x&quot;&gt;&amp;&#39; ");
    let lines = wrap("one two verylongwordwithoutblanks three", 10.0, false, 60.0);
    assert!(lines.len() > 3 && lines.iter().all(|l| width(l, 10.0, false) <= 60.0));
    assert_eq!(lines.concat().replace(' ', ""), "onetwoverylongwordwithoutblanksthree");
    assert!(width(&shorten("a rather long name", 12.0, 50.0), 12.0, false) <= 50.0);
}

#[test]
fn figures_are_kept_apart() {
    let a = Figure { title: "a".into(), panels: vec![Panel::default()], ..Figure::default() };
    let b = Figure { title: "b".into(), ..a.clone() };
    assert_ne!(figure::default_id(&a), figure::default_id(&b));
    let text = a.svg_with_id("one");
    for part in ["id=\"", "class=\""] {
        assert!(text.split(part).skip(1).all(|t| t.starts_with("one")));
    }
    assert_eq!(Canvas::new("1 {x}", 1.0).id, "chart1--x-");
}

#[test]
fn legend_is_shared_only_if_equal() {
    let line = |name: &str| Series::new(name, 0, Shape::Line, vec![[0.0, 1.0], [1.0, 2.0]]);
    let panel = |name: &str| Panel { series: vec![line(name)], ..Panel::default() };
    let count = |names: [&str; 2], wanted: &str| {
        let figure = Figure { columns: 2, panels: names.map(panel).to_vec(), ..Figure::default() };
        figure::compose(&figure, "x").boxes.iter().filter(|b| b.text == wanted).count()
    };
    assert_eq!(count(["fit", "fit"], "fit"), 1);
    assert_eq!(count(["fit", "data"], "fit"), 1);
    assert_eq!(count(["fit", "data"], "data"), 1);
}

#[test]
fn tooltips_end_at_400_points() {
    let dots = |n: usize| Series::new("s", 0, Shape::Dots, (0..n).map(|i| [i as f64, 0.5]).collect());
    let titles = |n: usize| {
        let panels = vec![Panel { series: vec![dots(n)], ..Panel::default() }];
        Figure { panels, ..Figure::default() }.svg().matches("<title>").count()
    };
    assert_eq!((titles(400), titles(401)), (400, 0));
}

/// The contrast ratio of two colours (WCAG 2).
pub(super) fn contrast(a: &str, b: &str) -> f64 {
    let luminance = |hex: &str| -> f64 {
        let part = |i: usize| {
            let v = f64::from(u8::from_str_radix(&hex[i..i + 2], 16).expect("hex")) / 255.0;
            if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * part(1) + 0.7152 * part(3) + 0.0722 * part(5)
    };
    let (a, b) = (luminance(a), luminance(b));
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

#[test]
fn contrasts_suffice() {
    for (mode, palette) in [LIGHT, DARK].iter().enumerate() {
        assert!(contrast(INK[mode], GROUND[mode]) >= 4.5 && contrast(FAINT[mode], GROUND[mode]) >= 4.5);
        palette.iter().for_each(|c| assert!(contrast(c, GROUND[mode]) >= 3.0, "{c}"));
    }
}

/// A figure with every shape, as it is stored.
#[test]
fn pictures_are_as_they_were() {
    let points = |values: &[f64]| values.iter().enumerate().map(|(k, v)| [k as f64, *v]).collect::<Vec<_>>();
    let ys = [1.0, 4.0, 2.0, 8.0];
    let ends = ys.iter().map(|y| [y - 0.5, y + 0.5]).collect();
    let panel = |title: &str, x: Axis, y: Axis, series: Vec<Series>| Panel {
        title: title.into(),
        x,
        y,
        series,
        rules: vec![Rule { horizontal: true, at: 3.0, label: "limit".into() }],
        ..Panel::default()
    };
    let lines = vec![
        Series::new("band", 2, Shape::Band { lower: vec![0.5; 4] }, points(&ys)),
        Series::new("line", 0, Shape::Line, points(&ys)),
        Series::new("dashed", 1, Shape::Dashed, points(&[2.0, 2.5, 3.0, 3.5])),
        Series::new("with dots", 3, Shape::LineWithDots, points(&[8.0, 6.0, 5.0, 1.0])),
    ];
    let marks = vec![
        Series::new("dots", 0, Shape::Dots, points(&ys)),
        Series::new("error bars", 1, Shape::ErrorBars { ends }, points(&ys)),
    ];
    let names = || vec!["xA1".to_owned(), "yA1".into(), "zA1".into(), "h1".into()];
    let bars = vec![Series::new("bars", 0, Shape::Bars { width: 0.6 }, points(&ys))];
    let circles = Shape::Bubbles { sizes: ys.to_vec(), full: 8.0 };
    let cells = Shape::Cells { values: vec![1.0, 0.5, 0.25, 0.001] };
    let figure = Figure {
        title: "Every shape".into(),
        description: "Lines, marks, bars, circles and cells.".into(),
        columns: 2,
        panels: vec![
            panel("Lines", Axis::linear("x (mm)"), Axis::linear("y (um)"), lines),
            panel("Marks", Axis::linear("x (mm)"), Axis::log("y (um)"), marks),
            panel("Bars", Axis::named("parameter", names()), Axis::linear("y (um)"), bars),
            panel(
                "Circles",
                Axis::linear("x"),
                Axis::linear("y"),
                vec![Series::new("circles", 4, circles, points(&ys))],
            ),
            Panel {
                rules: Vec::new(),
                ..panel(
                    "Cells",
                    Axis::named("", names()),
                    Axis::named("", names()),
                    vec![Series::new("cells", 5, cells, points(&[0.0, 1.0, 2.0, 3.0]))],
                )
            },
        ],
    };
    check(&figure, "shapes");
    insta::assert_snapshot!(figure.svg_with_id("shapes"));
}
