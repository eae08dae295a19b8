//! The page of `evaluate`.

use super::page::{Page, Part, Section, Tone};
use super::residuals::by_row;
use crate::identification::ModelErrors;
use crate::report::text;
use crate::units::{show_angle, show_length};

/// Errors of a model on measured data. `title` is the name of the mechanism, `noise` the stated noise of a vector length
/// (m, rad).
pub fn evaluation(
    errors: &ModelErrors,
    title: &str,
    noise: Option<(f64, f64)>,
    settings: Vec<(String, String)>,
) -> Page {
    let rms = errors.rms();
    let parts: Vec<String> =
        [rms.position.map(show_length), rms.rotation.map(show_angle)].into_iter().flatten().collect();
    Page {
        title: format!("{title}: errors of the model"),
        verdict: format!("{} rows: RMS error {}.", errors.samples.len(), parts.join(" and ")),
        tone: Tone::Good,
        lead: vec!["Nothing was fitted: the model predicts each row, and the page shows by how much it misses.".into()],
        sections: vec![Section {
            id: "errors",
            title: "Errors",
            parts: vec![
                Part::picture(by_row(&[("model", errors)], noise)),
                Part::Lines(text::evaluation(errors, title)),
            ],
        }],
        settings,
    }
}
