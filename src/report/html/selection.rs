//! The page of `select`.

use super::Subject;
use super::page::{Page, Part, Section, Tile, Tone};
use super::pictures::{Standing, coverage, drawing, how_many, trace};
use crate::pose::Pose;
use crate::report::text::{self, Selection};
use crate::selection::ChosenSet;
use crate::units::{show_angle, show_length, three_digits};

/// A choice of poses.
pub fn selection(s: &Selection<'_>, subject: &Subject<'_>) -> Page {
    let r = s.report;
    let forecast = r.forecast.as_ref().map(|f| f.error);
    let efficiency = r.efficiency.map(|e| format!("{:.2} %", 100.0 * e));
    let index = format!("index {}", r.index);
    let numbers = [
        Tile::of("poses", Some(r.poses.len().to_string()), format!("to measure, from {} candidates", r.candidates)),
        Tile::of(&index, Some(three_digits(r.value)), "of the chosen poses; what the search optimised"),
        Tile::of(
            "certified efficiency",
            efficiency.clone(),
            "of the best set that these candidates could make, at least",
        ),
        Tile::of(
            "predicted position error, RMS",
            forecast.map(|e| show_length(e.position_rms)),
            "of the calibrated pose over the workspace, 1 σ",
        ),
        Tile::of(
            "predicted angle error, RMS",
            forecast.map(|e| show_angle(e.rotation_rms)),
            "of the calibrated pose over the workspace, 1 σ",
        ),
    ];
    let sure = match &efficiency {
        Some(e) => {
            let n = r.poses.len();
            format!(
                "their {0} is certified to reach {e} of the best that any {n} of these candidates could \
                     reach",
                r.index
            )
        }
        None => format!("no bound is known for {}, so it is not known how much better another set could be", r.index),
    };
    let in_base: Vec<Pose> = r.poses.iter().map(|pose| subject.frames.platform(pose)).collect();
    let standing = Standing::of(subject.mechanism, &subject.frames);
    let mut poses = vec![Part::picture(coverage(&in_base, s.given, subject.convention))];
    poses.extend(drawing(subject.mechanism, &standing, &in_base, None, &[]).map(Part::drawing));
    let mut sections = vec![
        Section { id: "poses", title: "The poses", parts: poses },
        Section { id: "choice", title: "How the search converged", parts: vec![Part::picture(trace(r))] },
    ];
    if !s.table.is_empty() {
        let rows = s.table.iter().map(number_row).collect();
        let header = vec!["poses", "index", "efficiency", "position", "rotation"];
        let parts = vec![
            Part::picture(how_many(s.table, r.poses.len())),
            Part::table("The predicted errors in numbers", header, rows),
        ];
        sections.push(Section { id: "number", title: "How many poses", parts });
    }
    sections.push(Section { id: "numbers", title: "All numbers", parts: vec![Part::printed(text::selection(s))] });
    let good = r.efficiency.is_some_and(|e| e > 0.9) && subject.warnings.is_empty();
    Page {
        title: format!("{}: poses to measure", s.title),
        verdict: format!("{} poses to measure: {sure}.", r.poses.len() - s.given),
        tone: if good { Tone::Good } else { Tone::Mind },
        numbers: numbers.into_iter().flatten().collect(),
        lead: subject.lead(vec![advice(&text::next_step(s))]),
        sections,
        settings: subject.settings.clone(),
    }
}

/// The next step as the advice of a page.
fn advice(step: &str) -> String {
    let Some(measure) = step.strip_prefix("Measure") else { return step.to_owned() };
    match measure.split_once(", then: ") {
        Some((poses, command)) => format!("What to do: measure{poses}, then run `{command}`."),
        None => format!("What to do: measure{measure}."),
    }
}

/// A number of poses with what it promises, rounded as the tiles are.
fn number_row(r: &ChosenSet) -> Vec<String> {
    let error = r.forecast.as_ref().map(|f| f.error);
    let or_none = |text: Option<String>| text.unwrap_or_else(|| "-".into());
    vec![
        r.poses.len().to_string(),
        three_digits(r.value),
        or_none(r.efficiency.map(|e| format!("{:.2} %", 100.0 * e))),
        or_none(error.map(|e| show_length(e.position_rms))),
        or_none(error.map(|e| show_angle(e.rotation_rms))),
    ]
}
