//! The page of `evaluate`.

use super::page::{Page, Part, Section, Tone};
use super::pictures::{Displacements, Layer, Seen, by_row, drawing, gross, histograms, maps, strips};
use super::{Measured, Subject};
use crate::identification::ModelErrors;
use crate::report::text;
use crate::units::{show_angle, show_length};

/// Errors of a model on measured data; `measured` holds the data through that model.
pub fn evaluation(errors: &ModelErrors, subject: &Subject<'_>, measured: &Measured<'_>) -> Page {
    let title = subject.mechanism.name();
    let models: Vec<&Seen> = measured.models.iter().collect();
    let (rms, max) = (errors.rms(), errors.max());
    let parts: Vec<String> =
        [rms.position.map(show_length), rms.rotation.map(show_angle)].into_iter().flatten().collect();
    let numbers = [
        ("position error, RMS", rms.position.map(show_length)),
        ("largest", max.position.map(show_length)),
        ("angle error, RMS", rms.rotation.map(show_angle)),
        ("largest", max.rotation.map(show_angle)),
    ];
    let marked = gross(&models.first().map(|m| m.in_joints()).unwrap_or_default());
    let noise = measured.noise(subject.noise);
    let mut pictures = vec![
        Part::picture(by_row(&models, noise, &marked)),
        Part::picture(maps(&models, subject.convention, &marked)),
        Part::picture(histograms(&models, noise, &marked)),
    ];
    let mut layers = Vec::new();
    for (colour, seen) in models.iter().enumerate() {
        let poses: Vec<_> = seen.deviations.iter().map(|d| d.pose).collect();
        let arrows = Displacements::of(seen, subject.mechanism, &marked);
        pictures.extend(drawing(subject.mechanism, &poses, Some(&arrows), &[]).map(Part::drawing));
        layers.push(Layer { name: &seen.name, colour, residuals: seen.in_joints() });
    }
    let strips = strips(measured.data, subject.mechanism.joints(), &layers, &marked, &[]);
    Page {
        title: format!("{title}: errors of the model"),
        verdict: format!("{} rows: RMS error {}.", errors.samples.len(), parts.join(" and ")),
        tone: if subject.warnings.is_empty() { Tone::Good } else { Tone::Mind },
        numbers: numbers.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))).collect(),
        lead: subject.lead(vec![
            "Nothing was fitted: the model predicts each row, and the page shows by how much it misses. What to do if that is \
             too much: `paracal calibrate` finds parameters, `paracal diagnose` causes."
                .into(),
        ]),
        sections: vec![
            Section { id: "errors", title: "Errors", parts: pictures },
            Section { id: "legs", title: "Leg by leg", parts: strips.into_iter().map(Part::picture).collect() },
            Section { id: "numbers", title: "All numbers", parts: vec![Part::Lines(text::evaluation(errors, title))] },
        ],
        settings: subject.settings.clone(),
    }
}
