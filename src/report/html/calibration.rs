//! The page of `calibrate`.

use super::page::{Page, Part, Section, Tone, known};
use super::pictures::{Layer, ModelResiduals, correlation, deviations, gross, strips};
use super::{Measured, Subject};
use crate::identification::{Calibration, ModelErrors, SampleError};
use crate::measurement::DataRow;
use crate::report::chart::{Axis, Figure, Panel, Series, Shape};
use crate::report::text;
use crate::units::{shortened, show_angle, show_length};

/// Advice for a calibration that can be trusted.
const NEXT: &str = "compute commands with the calibrated file (`paracal compensate`), and run `paracal diagnose` to \
                    find errors in the data that geometry does not explain.";

/// A calibration; `measured` holds the data through the calibrated mechanism, then through the one that was given.
pub fn calibration(c: &Calibration, subject: &Subject<'_>, measured: &Measured<'_>) -> Page {
    let found = &c.identification;
    let summary = text::result_line(c);
    let (verdict, tone) = match (c.verdict.trusted, c.verdict.warnings.is_empty()) {
        (true, true) => ("The result can be trusted", Tone::Good),
        (true, false) => ("The result can be trusted, with warnings", Tone::Mind),
        (false, _) => ("The result must not be trusted", Tone::Bad),
    };
    let residuals = measured.models.first().map(ModelResiduals::in_joints).unwrap_or_default();
    let mut marked = gross(&residuals);
    marked.extend(&found.outliers);
    marked.sort_unstable();
    marked.dedup();
    let errors = measured.pictures(subject, &marked);
    let mut sections = vec![Section { id: "errors", title: "Errors before and after calibration", parts: errors }];
    if let Some(calibrated) = measured.models.first() {
        let layers = [Layer { name: &calibrated.name, colour: 0, residuals }];
        let strips = strips(measured.data, subject, &layers, &marked, &[]);
        let parts = strips.into_iter().map(Part::picture).collect();
        sections.push(Section { id: "legs", title: "Residuals, leg by leg", parts });
    }
    let mut parameters: Vec<Part> =
        deviations(&c.parameters[..found.mechanism_parameters]).into_iter().map(Part::picture).collect();
    parameters.push(match c.weak.is_empty() {
        true => Part::Text("The data determine all parameter directions.".into()),
        false => Part::Table(
            vec!["direction that the data do not determine", "tolerance over its uncertainty"],
            c.weak.iter().map(|w| vec![w.text.clone(), format!("{:.2}", w.sigma)]).collect(),
        ),
    });
    parameters.extend(correlation(&found.parameters, &found.correlation()).map(Part::picture));
    sections.push(Section { id: "parameters", title: "Parameters", parts: parameters });
    sections.push(Section { id: "convergence", title: "Convergence", parts: vec![Part::picture(convergence(c))] });
    sections.push(Section { id: "numbers", title: "All numbers", parts: vec![Part::Lines(text::calibration(c))] });
    let mut lead: Vec<String> = c.verdict.reasons.iter().chain(&c.verdict.warnings).cloned().collect();
    lead.push(format!("What to do: {}", if c.verdict.trusted { NEXT } else { text::WHAT_IS_WRONG }));
    Page {
        title: format!("{}: calibration", c.mechanism.name()),
        verdict: format!("{verdict}. {summary}"),
        tone,
        numbers: numbers(c, measured.models, &marked),
        lead: subject.lead(lead),
        sections,
        settings: subject.settings.clone(),
    }
}

/// The numbers of the first screen, without gross rows.
fn numbers(c: &Calibration, models: &[ModelResiduals], marked: &[DataRow]) -> Vec<(String, String)> {
    let held_out = c.held_out.as_ref().filter(|_| marked.is_empty()).map(|h| h.rms).unwrap_or_default();
    let rms = |k: usize| {
        let usual = |s: &&SampleError| !marked.contains(&s.row);
        let samples = models.get(k).map(|m| m.errors.samples.iter().filter(usual).copied().collect());
        ModelErrors { samples: samples.unwrap_or_default() }.rms()
    };
    let (after, before) = (rms(0), rms(1));
    let rows: Vec<String> = marked.iter().map(DataRow::to_string).collect();
    let numbers = [
        ("position error, as given", before.position.map(show_length)),
        ("position error, calibrated", after.position.map(show_length)),
        ("position error, held-out rows", held_out.position.map(show_length)),
        ("position error, predicted for the workspace", c.predicted.map(|p| show_length(p.position_rms))),
        ("angle error, as given", before.rotation.map(show_angle)),
        ("angle error, calibrated", after.rotation.map(show_angle)),
        ("angle error, held-out rows", held_out.rotation.map(show_angle)),
        ("angle error, predicted for the workspace", c.predicted.map(|p| show_angle(p.rotation_rms))),
        ("rows that look like gross errors, excluded from these numbers", (!rows.is_empty()).then(|| shortened(&rows))),
    ];
    known(numbers)
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
        description: "Half the sum of squares and largest step after each iteration, on logarithmic axes.".into(),
        columns: 2,
        panels: vec![panel("half the sum of squares", costs), panel("largest step (1e-3 SI)", steps)],
    }
}
