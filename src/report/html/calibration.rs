//! The page of `calibrate`.

use super::deviations::{judged, table};
use super::page::{Page, Part, Section, Tile, Tone};
use super::pictures::{Layer, ModelResiduals, correlation, deviations, gross, strips};
use super::{Measured, Subject, frames};
use crate::identification::{Calibration, ErrorSummary, ModelErrors, SampleError};
use crate::measurement::DataRow;
use crate::report::chart::{Axis, Figure, Panel, Series, Shape};
use crate::report::in_the_drawing::in_the_drawing;
use crate::report::text;
use crate::units::{Dimension, shortened, show_angle, show_length};

/// Advice for a calibration that can be trusted.
const NEXT: &str = "compute commands with the calibrated file (`paracal compensate`), and run `paracal diagnose` to \
                    find errors in the data that geometry does not explain.";

/// A calibration; `measured` holds the data through the calibrated mechanism, then through the one that was given.
pub fn calibration(c: &Calibration, subject: &Subject<'_>, measured: &Measured<'_>) -> Page {
    let found = &c.identification;
    let (verdict, tone) = match (c.verdict.trusted, c.verdict.warnings.is_empty()) {
        (true, true) => (text::trusted(c), Tone::Good),
        (true, false) => (format!("With warnings. {}", text::trusted(c)), Tone::Mind),
        (false, _) => ("The result must not be trusted".to_owned(), Tone::Bad),
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
    sections.push(Section { id: "parameters", title: "Parameters", parts: parameters(c) });
    sections.push(Section { id: "frames", title: "Frames", parts: frames(c, subject) });
    sections.push(Section { id: "convergence", title: "Convergence", parts: vec![Part::picture(convergence(c))] });
    sections.push(Section { id: "numbers", title: "All numbers", parts: vec![Part::printed(text::calibration(c))] });
    let mut lead: Vec<String> = c.verdict.reasons.iter().chain(&c.verdict.warnings).cloned().collect();
    lead.push(format!("What to do: {}", if c.verdict.trusted { NEXT } else { text::WHAT_IS_WRONG }));
    let errors = Errors::of(c, measured.models, &marked);
    Page {
        title: format!("{}: calibration", c.mechanism.name()),
        verdict: format!("{verdict}. {}", errors.headline(c)),
        tone,
        numbers: errors.tiles(c, &marked),
        lead: subject.lead(lead),
        sections,
        settings: subject.settings.clone(),
    }
}

/// Deviations as a picture and as a table, and what the data do not determine.
fn parameters(c: &Calibration) -> Vec<Part> {
    let found = &c.identification;
    let n = found.mechanism_parameters;
    let all = in_the_drawing(c);
    let mut parts = Vec::new();
    if c.registration.applied {
        parts.push(Part::Text(
            "Deviations are those of the machine, in the base frame and the platform frame of the mechanism file: the rigid \
             motions of base and platform, which say where tracker and target were, are taken out of the points and listed \
             under Frames, as are the offsets of the legs. The calibrated file has the same machine in the frames of the measurement."
                .into(),
        ));
    }
    if let Some((figure, beyond)) = deviations(&judged(&all[..n])) {
        parts.push(Part::picture(figure));
        if !beyond.is_empty() {
            parts.push(Part::Text(format!("Beyond the picture: {}.", beyond.join(", "))));
        }
    }
    parts.push(table(&all));
    parts.push(match c.weak.is_empty() {
        true => Part::Text("The data determine all parameter directions.".into()),
        false => Part::table(
            "Directions that the data do not determine",
            vec!["direction that the data do not determine", "tolerance over its uncertainty"],
            c.weak.iter().map(|w| vec![w.text.clone(), format!("{:.2}", w.sigma)]).collect(),
        ),
    });
    parts.extend(correlation(&found.parameters, &found.correlation()).map(Part::picture));
    parts
}

/// Where tracker and target were, and the offsets of the legs.
fn frames(c: &Calibration, subject: &Subject<'_>) -> Vec<Part> {
    let n = c.identification.mechanism_parameters;
    let mut parts = vec![match c.registration.applied {
        true => Part::Text(frames::sentence(&c.plausibility)),
        false => Part::Text("The data are in the frames of the mechanism file, up to these small motions.".into()),
    }];
    parts.push(frames::motions(&c.plausibility));
    parts.extend(frames::offsets(subject.mechanism, &c.plausibility, &c.identification.parameters[..n]));
    parts
}

/// The errors of the first screen, without gross rows: the same numbers in the headline and in the tiles.
struct Errors {
    before: ErrorSummary,
    after: ErrorSummary,
    held_out: ErrorSummary,
}

impl Errors {
    fn of(c: &Calibration, models: &[ModelResiduals], marked: &[DataRow]) -> Self {
        let rms = |k: usize| {
            let usual = |s: &&SampleError| !marked.contains(&s.row);
            let samples = models.get(k).map(|m| m.errors.samples.iter().filter(usual).copied().collect());
            ModelErrors { samples: samples.unwrap_or_default() }.rms()
        };
        let held_out = c.held_out.as_ref().filter(|_| marked.is_empty()).map(|h| h.rms).unwrap_or_default();
        Self { before: rms(1), after: rms(0), held_out }
    }

    /// How much better the calibrated mechanism is, in a sentence.
    fn headline(&self, c: &Calibration) -> String {
        let positions = self.after.position.is_some();
        let shown = |e: &ErrorSummary| match positions {
            true => e.position.map(show_length),
            false => e.rotation.map(show_angle),
        };
        let of = [(&self.before, "as given"), (&self.after, "calibrated"), (&self.held_out, "on held-out rows")];
        let parts: Vec<String> = of.into_iter().filter_map(|(e, name)| Some(format!("{} {name}", shown(e)?))).collect();
        format!(
            "{} parameters from {} poses: RMS {} error {}.",
            c.parameters.len(),
            c.identification.poses.len(),
            if positions { "position" } else { "angle" },
            parts.join(", ")
        )
    }

    fn tiles(&self, c: &Calibration, marked: &[DataRow]) -> Vec<Tile> {
        let given = match c.registration.applied {
            true => "RMS of the mechanism file, once the frames of the data are found",
            false => "RMS of the mechanism file",
        };
        let expected = "RMS of the calibrated pose, 1 σ, without the noise of a reading";
        let (fitted, others) =
            ("RMS on the fitted rows, noise included", "RMS on rows that were not fitted, noise included");
        let Self { before, after, held_out } = self;
        let predicted = c.predicted.as_ref().filter(|_| c.verdict.trusted);
        let rows: Vec<String> = marked.iter().map(DataRow::to_string).collect();
        let numbers = [
            Tile::of("position error, as given", before.position.map(show_length), given),
            Tile::of("position error, calibrated", after.position.map(show_length), fitted),
            Tile::of("position error, held-out rows", held_out.position.map(show_length), others),
            Tile::of("position error, predicted", predicted.map(|p| show_length(p.position_rms)), expected),
            Tile::of("angle error, as given", before.rotation.map(show_angle), given),
            Tile::of("angle error, calibrated", after.rotation.map(show_angle), fitted),
            Tile::of("angle error, held-out rows", held_out.rotation.map(show_angle), others),
            Tile::of("angle error, predicted", predicted.map(|p| show_angle(p.rotation_rms)), expected),
            Tile::of(
                "rows that look like gross errors, excluded from these numbers",
                (!rows.is_empty()).then(|| shortened(&rows)),
                "data rows, counted from 0",
            ),
        ];
        numbers.into_iter().flatten().collect()
    }
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
    let are = |wanted: &[Dimension]| c.parameters.iter().all(|p| wanted.contains(&p.spec.dimension));
    let unit = match () {
        () if are(&[Dimension::Length]) => "mm",
        () if are(&[Dimension::Length, Dimension::Angle]) => "mm or mrad",
        () => "thousandths of the SI unit",
    };
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
        panels: vec![panel("half the sum of squares", costs), panel(&format!("largest step ({unit})"), steps)],
    }
}
