//! The page of `evaluate`.

use super::page::{Page, Part, Section, Tile, Tone};
use super::pictures::{Layer, ModelResiduals, gross, strips};
use super::{Measured, Subject};
use crate::identification::ModelErrors;
use crate::report::text;
use crate::units::{show_angle, show_length};

/// Errors of a model on measured data; `measured` holds the data through that model.
pub fn evaluation(errors: &ModelErrors, subject: &Subject<'_>, measured: &Measured<'_>) -> Page {
    let title = subject.mechanism.name();
    let (rms, max) = (errors.rms(), errors.max());
    let parts: Vec<String> =
        [rms.position.map(show_length), rms.rotation.map(show_angle)].into_iter().flatten().collect();
    let (all, one) = ("over all measured rows, noise included", "of a single row");
    let numbers = [
        Tile::of("position error, RMS", rms.position.map(show_length), all),
        Tile::of("largest position error", max.position.map(show_length), one),
        Tile::of("angle error, RMS", rms.rotation.map(show_angle), all),
        Tile::of("largest angle error", max.rotation.map(show_angle), one),
    ];
    let marked = gross(&measured.models.first().map(ModelResiduals::in_joints).unwrap_or_default());
    let models = measured.models.iter().enumerate();
    let layers: Vec<Layer<'_>> =
        models.map(|(colour, seen)| Layer { name: &seen.name, colour, residuals: seen.in_joints() }).collect();
    let strips = strips(measured.data, subject, &layers, &marked, &[]);
    Page {
        title: format!("{title}: errors of the model"),
        verdict: format!("{} rows: RMS error {}.", errors.samples.len(), parts.join(" and ")),
        tone: if subject.warnings.is_empty() { Tone::Good } else { Tone::Mind },
        numbers: numbers.into_iter().flatten().collect(),
        lead: subject.lead(vec![
            "Nothing was fitted: the model predicts each row, and this page shows how far off it is. What to do if \
             that is too much: `paracal calibrate` identifies parameters, `paracal diagnose` looks for causes."
                .into(),
        ]),
        sections: vec![
            Section { id: "errors", title: "Errors", parts: measured.pictures(subject, &marked) },
            Section { id: "legs", title: "Leg by leg", parts: strips.into_iter().map(Part::picture).collect() },
            Section {
                id: "numbers",
                title: "All numbers",
                parts: vec![Part::printed(text::evaluation(errors, title))],
            },
        ],
        settings: subject.settings.clone(),
    }
}
