//! The page of `calibrate`.

use super::page::{Page, Part, Section, Tone};
use super::residuals::{Named, by_row};
use crate::identification::{Calibration, Estimate};
use crate::report::chart::{Axis, Figure, Panel, Series, Shape};
use crate::units::Dimension;

/// A calibration. `text` is what the command prints, `models` the errors of the models to compare row by row, `noise` the
/// stated noise of a vector length (m, rad).
pub fn calibration(
    c: &Calibration,
    title: &str,
    text: &str,
    models: &[Named<'_>],
    noise: Option<(f64, f64)>,
    settings: Vec<(String, String)>,
) -> Page {
    let found = &c.identification;
    let summary = text.lines().last().unwrap_or_default();
    let (verdict, tone) = match (c.verdict.trusted, c.verdict.warnings.is_empty()) {
        (true, true) => ("The result can be trusted", Tone::Good),
        (true, false) => ("The result can be trusted, with warnings", Tone::Mind),
        (false, _) => ("The result must not be trusted", Tone::Bad),
    };
    let mut sections = vec![Section {
        id: "errors",
        title: "Where it was wrong, and what is left",
        parts: vec![Part::picture(by_row(models, noise))],
    }];
    let mut parameters: Vec<Part> =
        deviations(&c.parameters[..found.mechanism_parameters]).into_iter().map(Part::picture).collect();
    parameters.push(match c.weak.is_empty() {
        true => Part::Text("The data decide all directions of the parameters.".into()),
        false => Part::Table(
            vec!["direction that the data do not decide", "tolerance over its uncertainty"],
            c.weak.iter().map(|w| vec![w.text.clone(), format!("{:.2}", w.sigma)]).collect(),
        ),
    });
    sections.push(Section { id: "parameters", title: "Parameters", parts: parameters });
    sections.push(Section { id: "convergence", title: "Convergence", parts: vec![Part::picture(convergence(c))] });
    sections.push(Section { id: "numbers", title: "All numbers", parts: vec![Part::Lines(text.to_owned())] });
    Page {
        title: format!("{title}: calibration"),
        verdict: format!("{verdict}. {summary}"),
        tone,
        lead: c.verdict.reasons.iter().chain(&c.verdict.warnings).cloned().collect(),
        sections,
        settings,
    }
}

/// Deviations of lengths from the file with ± 2 σ, mm.
fn deviations(parameters: &[Estimate]) -> Option<Figure> {
    let lengths: Vec<&Estimate> = parameters.iter().filter(|p| p.spec.dimension == Dimension::Length).collect();
    if lengths.is_empty() {
        return None;
    }
    let mm = |p: &Estimate| 1e3 * (p.value - p.start);
    let points: Vec<[f64; 2]> = lengths.iter().enumerate().map(|(k, p)| [k as f64, mm(p)]).collect();
    let end = |p: &&Estimate| {
        let half = 2e3 * p.sigma.unwrap_or(0.0);
        [mm(p) - half, mm(p) + half]
    };
    let ends = lengths.iter().map(end).collect();
    let mut series = vec![Series::new("deviation, ± 2 sigma", 0, Shape::ErrorBars { ends }, points)];
    let tolerance = |sign: f64| -> Vec<[f64; 2]> {
        let at = |(k, p): (usize, &&Estimate)| Some([k as f64, sign * 1e3 * p.spec.tolerance?]);
        lengths.iter().enumerate().filter_map(at).collect()
    };
    series.push(Series::new("tolerance, 1 sigma", 1, Shape::Dashed, tolerance(1.0)));
    series.push(Series::new("tolerance, 1 sigma", 1, Shape::Dashed, tolerance(-1.0)));
    let panel = Panel {
        x: Axis::named("parameter", lengths.iter().map(|p| p.spec.name.clone()).collect()),
        y: Axis::linear("deviation from the file (mm)"),
        series,
        ..Panel::default()
    };
    Some(Figure {
        title: "Deviations of the parameters".into(),
        description: "Deviation of each parameter from the mechanism file with its uncertainty, beside the tolerance."
            .into(),
        columns: 1,
        panels: vec![panel],
    })
}

fn convergence(c: &Calibration) -> Figure {
    let history = &c.identification.history;
    // A linear axis would have ticks between few iterations.
    let few = history.len() <= 12;
    let (x, first) = if few {
        (Axis::named("iteration", (1..=history.len()).map(|k| k.to_string()).collect()), 0.0)
    } else {
        (Axis::linear("iteration"), 1.0)
    };
    let costs = history.iter().enumerate().map(|(k, h)| [k as f64 + first, h.cost]).collect();
    let steps = history.iter().enumerate().map(|(k, h)| [k as f64 + first, 1e3 * h.step]).collect();
    let panel = |label: &str, points: Vec<[f64; 2]>| Panel {
        x: x.clone(),
        y: Axis::log(label),
        series: vec![Series::new("", 0, Shape::LineWithDots, points)],
        ..Panel::default()
    };
    Figure {
        title: "Convergence".into(),
        description: "Sum of squares and largest step after each iteration, on logarithmic axes.".into(),
        columns: 2,
        panels: vec![panel("half the sum of squares", costs), panel("largest step (1e-3 SI)", steps)],
    }
}
