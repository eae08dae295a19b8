//! The page of `diagnose`.

use super::page::{Page, Part, Section, Tone};
use super::residuals::{ARCSECONDS, MICROMETRES};
use crate::diagnosis::{Cause, Diagnosis, Verdict};
use crate::report::chart::{Axis, Figure, Panel, Rule, Series, Shape};
use crate::report::text;
use crate::units::{show_probability, show_quantity, three_digits};

/// A diagnosis. `title` is the name of the mechanism.
pub fn diagnosis(d: &Diagnosis, title: &str, settings: Vec<(String, String)>) -> Page {
    let tone = match d.verdict {
        Verdict::Clean | Verdict::Named => Tone::Good,
        Verdict::Tied | Verdict::Unknown => Tone::Mind,
        Verdict::Misread => Tone::Bad,
    };
    let remedy = |c: &Cause| format!("{}: {}. What to do: {}.", c.effect, c.cause, c.remedy);
    let mut lead: Vec<String> = d.causes.iter().map(remedy).collect();
    lead.extend(d.warnings.iter().cloned());
    if d.verdict == Verdict::Tied || d.verdict == Verdict::Unknown {
        lead.push("What to measure next: `paracal settle` with the same files.".into());
    }
    let mut sections = Vec::new();
    if d.gain.position_before.is_some() || d.gain.rotation_before.is_some() {
        sections.push(Section { id: "gain", title: "What is gained", parts: vec![Part::picture(gain(d))] });
    }
    if !d.causes.is_empty() {
        let parts =
            vec![Part::Table(CAUSES.to_vec(), d.causes.iter().map(cause_row).collect()), Part::picture(sizes(d))];
        sections.push(Section { id: "causes", title: "Causes", parts });
    }
    if !d.not_found.is_empty() {
        let row = |n: &crate::diagnosis::NotFound| {
            vec![n.effect.clone(), n.parameter.clone(), show_quantity(n.limit, n.dimension)]
        };
        let rows = d.not_found.iter().map(row).collect();
        let header = vec!["looked for and not found", "parameter", "would have been seen from"];
        sections.push(Section { id: "limits", title: "Detection limits", parts: vec![Part::Table(header, rows)] });
    }
    if !d.not_testable.is_empty() {
        let rows = d.not_testable.iter().map(|n| vec![n.effect.clone(), n.missing.join(", ")]).collect();
        let parts = vec![Part::Table(vec!["could not be tested", "what is missing"], rows)];
        sections.push(Section { id: "missing", title: "Not testable", parts });
    }
    let numbers = vec![Part::Lines(text::diagnosis(d, title))];
    sections.push(Section { id: "numbers", title: "All numbers", parts: numbers });
    Page { title: format!("{title}: diagnosis"), verdict: text::verdict(d), tone, lead, sections, settings }
}

const CAUSES: [&str; 7] = ["cause", "leg", "parameters", "evidence, nats", "p", "over its limit", "not excluded"];

fn cause_row(c: &Cause) -> Vec<String> {
    let values = c.parameters.iter().map(|p| {
        let sigma = p.sigma.map_or_else(String::new, |s| format!(" ± {}", show_quantity(s, p.dimension)));
        format!("{} {}{sigma}", p.name, show_quantity(p.value, p.dimension))
    });
    let rivals: Vec<&str> = c.tied_with.iter().map(|r| r.effect.as_str()).collect();
    vec![
        c.effect.clone(),
        c.leg.map_or_else(String::new, |leg| (leg + 1).to_string()),
        values.collect::<Vec<_>>().join("; "),
        three_digits(c.evidence),
        show_probability(c.p_value),
        format!("{}{}", three_digits(c.size_over_limit), if c.tentative { " (tentative)" } else { "" }),
        rivals.join(", "),
    ]
}

/// Held-out errors without and with the causes.
fn gain(d: &Diagnosis) -> Figure {
    let g = &d.gain;
    let panel = |title: &str, label: &str, before: Option<f64>, after: Option<f64>, floor: Option<f64>, unit: f64| {
        let points = [before, after].iter().enumerate().filter_map(|(k, v)| Some([k as f64, unit * (*v)?])).collect();
        Panel {
            title: title.into(),
            x: Axis::named("", vec!["parameters alone".into(), "with the causes".into()]),
            y: Axis::linear(label),
            series: vec![Series::new("", 0, Shape::Bars { width: 0.5 }, points)],
            rules: floor
                .map(|at| Rule { horizontal: true, at: unit * at, label: "stated noise".into() })
                .into_iter()
                .collect(),
            ..Panel::default()
        }
    };
    Figure {
        title: "Error on rows that were not fitted".into(),
        description:
            "RMS position and angle error on held-out rows, with the kinematic parameters alone and with the causes, \
                      beside the stated noise."
                .into(),
        columns: 2,
        panels: vec![
            panel("Position", "RMS (um)", g.position_before, g.position_after, g.noise_floor_position, MICROMETRES),
            panel("Attitude", "RMS (arcsec)", g.rotation_before, g.rotation_after, g.noise_floor_rotation, ARCSECONDS),
        ],
    }
}

/// Values of the causes over their usual sizes.
fn sizes(d: &Diagnosis) -> Figure {
    let all: Vec<(String, f64, f64)> = d
        .causes
        .iter()
        .flat_map(|c| {
            let name = move |p: &str| format!("{} {p}", c.effect);
            c.parameters.iter().map(move |p| (name(&p.name), p.value / p.scale, 2.0 * p.sigma.unwrap_or(0.0) / p.scale))
        })
        .collect();
    let points = all.iter().enumerate().map(|(k, (_, v, _))| [k as f64, *v]).collect();
    let ends = all.iter().map(|(_, v, half)| [v - half, v + half]).collect();
    let panel = Panel {
        x: Axis::named("parameter", all.iter().map(|(name, ..)| name.clone()).collect()),
        y: Axis::linear("value over its usual size, ± 2 sigma"),
        series: vec![Series::new("", 0, Shape::ErrorBars { ends }, points)],
        rules: vec![Rule { horizontal: true, at: 0.0, label: "none".into() }],
        ..Panel::default()
    };
    Figure {
        title: "Sizes of the causes".into(),
        description: "Each value of the named causes over the usual size of its effect, with its uncertainty.".into(),
        columns: 1,
        panels: vec![panel],
    }
}
