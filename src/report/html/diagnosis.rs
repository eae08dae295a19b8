//! The page of `diagnose`.

use super::page::{Page, Part, Section, Tile, Tone};
use super::pictures::{Layer, Standing, added_variable, conditions, drawing, gain, sizes, strips};
use super::{Subject, frames};
use crate::diagnosis::{Cause, Diagnosis, MeasurementPlan, Rival, Verdict};
use crate::identification::{Plausibility, plausibility};
use crate::measurement::Dataset;
use crate::report::text;
use crate::units::{show_angle, show_length, show_probability, show_quantity, three_digits};

/// Causes in the headline.
const HEADLINE: usize = 3;

/// A diagnosis of data, with the measurements that would settle what is open.
pub fn diagnosis(d: &Diagnosis, plans: &[MeasurementPlan], subject: &Subject<'_>, data: &Dataset) -> Page {
    let title = subject.mechanism.name();
    let tone = match d.verdict {
        Verdict::Clean if text::understated(d).is_some() => Tone::Mind,
        Verdict::Named if d.causes.iter().any(|c| c.tentative) => Tone::Mind,
        Verdict::Clean | Verdict::Named => Tone::Good,
        Verdict::Tied | Verdict::Unknown => Tone::Mind,
        Verdict::Undecided | Verdict::Misread => Tone::Bad,
    };
    let mut meanings = text::meanings(d);
    let mut lead = Vec::new();
    let mut verdict = text::verdict(d);
    if matches!(d.verdict, Verdict::Named | Verdict::Tied) && !meanings.is_empty() {
        // The headline says what it means, for readers who read nothing else.
        let headline: Vec<String> = meanings.drain(..meanings.len().min(HEADLINE)).collect();
        lead.push(std::mem::replace(&mut verdict, headline.join(" ")));
    }
    lead.extend(meanings);
    let tentative: Vec<&str> = d.causes.iter().filter(|c| c.tentative).map(|c| c.effect.as_str()).collect();
    if !tentative.is_empty() {
        lead.push(format!(
            "Tentative: {}. The name may be right, but the size is near what these data can detect: more poses, or a wider \
             range of the condition, make it sure.",
            tentative.join(", ")
        ));
    }
    for c in d.causes.iter().filter(|c| !c.not_excluded.is_empty()) {
        lead.push(format!(
            "Not excluded beside {}: {}, which could not be tested because their sensors are missing.",
            c.effect,
            c.not_excluded.join(", ")
        ));
    }
    lead.extend(d.warnings.iter().cloned());
    if let Some(plan) = plans.first() {
        lead.push(format!("What to measure next: {}; `paracal settle` writes the poses.", plan.what));
    } else if matches!(d.verdict, Verdict::Tied | Verdict::Unknown) {
        lead.push(what_of_unknown(d));
    }
    let mut sections = Vec::new();
    if !d.causes.is_empty() && (d.gain.position_before.is_some() || d.gain.rotation_before.is_some()) {
        sections.push(Section { id: "gain", title: "Improvement", parts: vec![Part::picture(gain(d))] });
    }
    if !d.causes.is_empty() {
        let parts = vec![
            with_content(&CAUSES, &d.causes.iter().map(cause_row).collect::<Vec<_>>()),
            Part::picture(added_variable(&d.causes)),
            Part::picture(sizes(d)),
        ];
        sections.push(Section { id: "causes", title: "Causes", parts });
        let rivals: Vec<Vec<String>> = d.causes.iter().flat_map(rival_rows).collect();
        if !rivals.is_empty() {
            let mut parts = vec![Part::Table(RIVALS.to_vec(), rivals)];
            if !plans.is_empty() {
                parts.push(Part::Lines(text::settlement(d, plans, title)));
            }
            sections.push(Section { id: "rivals", title: "What else it could be", parts });
        }
    }
    if !d.residuals.is_empty() {
        sections.push(Section { id: "legs", title: "Residuals, leg by leg", parts: legs(d, subject, data) });
    }
    if let Some(figure) = conditions(data, subject.condition_kinds) {
        let parts = vec![Part::picture(figure)];
        sections.push(Section { id: "conditions", title: "Conditions of the run", parts });
    }
    sections.push(Section { id: "frames", title: "Frames", parts: standing(d, subject) });
    if !d.not_found.is_empty() {
        let row = |n: &crate::diagnosis::NotFound| {
            vec![n.effect.clone(), n.parameter.clone(), show_quantity(n.limit, n.dimension)]
        };
        let rows = d.not_found.iter().map(row).collect();
        let header = vec!["tested and not found", "parameter", "detectable from"];
        sections.push(Section {
            id: "limits",
            title: "Detection limits",
            parts: vec![Part::table("Detection limits", header, rows)],
        });
    }
    if !d.not_testable.is_empty() {
        let rows = d.not_testable.iter().map(|n| vec![n.effect.clone(), n.missing.join(", ")]).collect();
        let parts = vec![Part::table("Not testable", vec!["could not be tested", "what is missing"], rows)];
        sections.push(Section { id: "missing", title: "Not testable", parts });
    }
    let text = Part::printed(text::diagnosis(d, title));
    sections.push(Section { id: "numbers", title: "All numbers", parts: vec![text] });
    Page {
        title: format!("{title}: diagnosis"),
        verdict,
        tone,
        numbers: numbers(d),
        lead: subject.lead(lead),
        sections,
        settings: subject.settings.clone(),
    }
}

/// Advice if part of the residual has no named cause.
fn what_of_unknown(d: &Diagnosis) -> String {
    let Some((unknown, covariate)) = d.unknown.as_ref().and_then(|u| Some((u, u.covariate.as_ref()?))) else {
        return "What to do: record more of the conditions that may have changed, and measure again.".into();
    };
    let leg = match (unknown.leg, unknown.coordinate) {
        (Some(leg), _) => format!(" at leg {}", leg + 1),
        (None, Some(k)) => format!(" and moves {} of the platform as it is seen", crate::diagnosis::COORDINATES[k]),
        (None, None) => String::new(),
    };
    let other = unknown.runner_up.as_ref();
    let other = other.map_or_else(String::new, |r| format!("; {r} explains it nearly as well"));
    format!("What to do: look at what changes with {covariate}{leg}{other}, and measure over a wider range of it.")
}

/// Where tracker and target were, the offsets of the legs, and the mechanism with the legs that causes name.
fn standing(d: &Diagnosis, subject: &Subject<'_>) -> Vec<Part> {
    if d.verdict == Verdict::Misread || d.values.len() < subject.mechanism.parameters().len() {
        return Vec::new();
    }
    let found = plausibility(subject.mechanism, &d.values);
    // The mechanism of a calibrated file stands in a frame of its own.
    let base = d.frames.base.compose(&found.base).compose(&subject.frames.base);
    let target = subject.frames.target.compose(&found.target).compose(&d.frames.target);
    let found = Plausibility { base, target, ..found };
    let mut parts = vec![Part::Text(frames::sentence(&found)), frames::motions(&found)];
    let offsets = frames::offsets(subject.mechanism, &found, &[]);
    let marked: Vec<usize> = d.causes.iter().filter_map(|c| c.leg).collect();
    let seen = Standing::of(subject.mechanism, &subject.frames).seen_from(&found.base);
    match (offsets, drawing(subject.mechanism, &seen, &[], None, &marked).map(Part::drawing)) {
        (Some(offsets), Some(drawing)) => parts.push(Part::Row(vec![drawing, offsets])),
        (offsets, drawing) => parts.extend(offsets.into_iter().chain(drawing)),
    }
    parts
}

fn numbers(d: &Diagnosis) -> Vec<Tile> {
    let (g, named) = (&d.gain, !d.causes.is_empty());
    let alone = "RMS on rows that were not fitted, with the kinematic parameters alone";
    let with = "RMS on rows that were not fitted, with the causes in the model";
    let rows = [
        Tile::of("position error, parameters alone", g.position_before.map(show_length), alone),
        Tile::of("position error, with the causes", g.position_after.filter(|_| named).map(show_length), with),
        Tile::of("angle error, parameters alone", g.rotation_before.map(show_angle), alone),
        Tile::of("angle error, with the causes", g.rotation_after.filter(|_| named).map(show_angle), with),
        Tile::of(
            "noise over the stated noise",
            d.noise_scale.is_finite().then(|| three_digits(d.noise_scale)),
            "what is left, in units of the stated noise; 1 is as stated",
        ),
    ];
    rows.into_iter().flatten().collect()
}

/// Residuals of each leg without causes and with them.
fn legs(d: &Diagnosis, subject: &Subject<'_>, data: &Dataset) -> Vec<Part> {
    let mut layers = Vec::new();
    if !d.causes.is_empty() {
        let residuals = d.residuals.iter().map(|r| (r.row, r.before.as_slice())).collect();
        layers.push(Layer { name: "kinematic parameters alone", colour: 3, residuals });
    }
    let residuals = d.residuals.iter().map(|r| (r.row, r.after.as_slice())).collect();
    let name = if d.causes.is_empty() { "kinematic parameters alone" } else { "with the causes" };
    layers.push(Layer { name, colour: 0, residuals });
    let of_unknown = d.unknown.iter().flat_map(|u| u.covariate.iter().chain(&u.runner_up));
    let further: Vec<&str> =
        of_unknown.chain(d.causes.iter().filter_map(|c| c.of.as_ref())).map(String::as_str).collect();
    let strips = strips(data, subject, &layers, &d.outlier_rows, &further);
    strips.into_iter().map(Part::picture).collect()
}

const RIVALS: [&str; 5] =
    ["named", "also possible", "values it would have", "nats behind", "separability, 10 is needed"];

fn rival_rows(c: &Cause) -> Vec<Vec<String>> {
    let row = |r: &Rival| {
        let part = |r: &Rival| {
            let place = [
                r.leg.map(|leg| format!(" leg {}", leg + 1)),
                r.row.map(|row| format!(" from data row {row}")),
                r.of.as_ref().map(|of| format!(" ({of})")),
            ];
            format!("{}{}", r.effect, place.into_iter().flatten().collect::<String>())
        };
        let values: Vec<String> = r.parts().flat_map(|r| &r.values).map(|v| three_digits(*v)).collect();
        vec![
            c.effect.clone(),
            r.parts().map(part).collect::<Vec<_>>().join(" together with "),
            format!("{} (SI)", values.join(", ")),
            three_digits(r.log_bayes_factor),
            three_digits(r.separability),
        ]
    };
    c.tied_with.iter().map(row).collect()
}

const CAUSES: [&str; 7] =
    ["cause", "leg", "parameters", "evidence, nats", "p", "relative to its limit", "not excluded"];

/// A table without the columns in which no row has anything.
fn with_content(header: &[&'static str], rows: &[Vec<String>]) -> Part {
    let filled = |k: &usize| rows.iter().any(|row| row.get(*k).is_some_and(|cell| !cell.is_empty()));
    let kept: Vec<usize> = (0..header.len()).filter(filled).collect();
    let row = |row: &Vec<String>| kept.iter().filter_map(|k| row.get(*k).cloned()).collect();
    let header = kept.iter().filter_map(|k| header.get(*k).copied()).collect();
    Part::Table(header, rows.iter().map(row).collect())
}

fn cause_row(c: &Cause) -> Vec<String> {
    let values = c.parameters.iter().map(|p| {
        let sigma = p.sigma.map_or_else(String::new, |s| format!(" ± {}", show_quantity(s, p.dimension)));
        format!("{} {}{sigma}", p.name, show_quantity(p.value, p.dimension))
    });
    let rivals: Vec<String> = c.tied_with.iter().map(Rival::label).collect();
    vec![
        c.effect.clone(),
        c.leg.map_or_else(String::new, |leg| (leg + 1).to_string()),
        values.collect::<Vec<_>>().join("; "),
        three_digits(c.evidence),
        show_probability(c.p_value).trim_start_matches("= ").to_owned(),
        format!("{}{}", three_digits(c.size_over_limit), if c.tentative { " (tentative)" } else { "" }),
        rivals.join(", "),
    ]
}
