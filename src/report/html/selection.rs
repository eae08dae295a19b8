//! The page of `select`.

use super::Subject;
use super::page::{Page, Part, Section, Tone, known};
use super::pictures::{coverage, drawing, how_many, trace};
use crate::report::text::{self, Selection};
use crate::units::{show_angle, show_length, three_digits};

/// A choice of poses.
pub fn selection(s: &Selection<'_>, subject: &Subject<'_>) -> Page {
    let r = s.report;
    let forecast = r.forecast.as_ref().map(|f| f.error);
    let efficiency = r.efficiency.map(|e| format!("{:.2} %", 100.0 * e));
    let numbers = [
        ("poses", Some(r.poses.len().to_string())),
        (r.index.as_str(), Some(three_digits(r.value))),
        ("certified efficiency", efficiency.clone()),
        ("predicted position error, RMS", forecast.map(|e| show_length(e.position_rms))),
        ("predicted angle error, RMS", forecast.map(|e| show_angle(e.rotation_rms))),
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
    let mut poses = vec![Part::picture(coverage(r, s.given, subject.convention))];
    poses.extend(drawing(subject.mechanism, &r.poses, None, &[]).map(Part::drawing));
    let mut sections = vec![
        Section { id: "poses", title: "The poses", parts: poses },
        Section { id: "choice", title: "How the search converged", parts: vec![Part::picture(trace(r))] },
    ];
    if !s.table.is_empty() {
        let rows = s.table.iter().map(text::number_row).collect();
        let parts = vec![
            Part::picture(how_many(s.table, r.poses.len())),
            Part::Table(vec!["poses", "index", "efficiency", "position", "rotation"], rows),
        ];
        sections.push(Section { id: "number", title: "How many poses", parts });
    }
    sections.push(Section { id: "numbers", title: "All numbers", parts: vec![Part::Lines(text::selection(s))] });
    let good = r.efficiency.is_some_and(|e| e > 0.9) && subject.warnings.is_empty();
    Page {
        title: format!("{}: poses to measure", s.title),
        verdict: format!("{} poses to measure: {sure}.", r.poses.len() - s.given),
        tone: if good { Tone::Good } else { Tone::Mind },
        numbers: known(numbers),
        lead: subject.lead(vec![format!("What to do: {}.", text::next_step(s))]),
        sections,
        settings: subject.settings.clone(),
    }
}
