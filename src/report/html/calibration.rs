//! The page of `calibrate`.

use super::page::{Page, Part, Section, Tone};
use super::pictures::{Displacements, Layer, Seen, by_row, correlation, deviations, drawing, histograms, maps, strips};
use super::{Measured, Subject};
use crate::identification::Calibration;
use crate::report::chart::{Axis, Figure, Panel, Series, Shape};
use crate::report::text;
use crate::units::{show_angle, show_length};

/// Rows beyond this many robust σ of a leg look like gross errors.
const GROSS: f64 = 8.0;

/// A calibration. `printed` is what the command prints; `measured` holds the data through the calibrated mechanism, then
/// through the one that was given.
pub fn calibration(c: &Calibration, printed: &str, subject: &Subject<'_>, measured: &Measured<'_>) -> Page {
    let found = &c.identification;
    let summary = printed.lines().last().unwrap_or_default();
    let (verdict, tone) = match (c.verdict.trusted, c.verdict.warnings.is_empty()) {
        (true, true) => ("The result can be trusted", Tone::Good),
        (true, false) => ("The result can be trusted, with warnings", Tone::Mind),
        (false, _) => ("The result must not be trusted", Tone::Bad),
    };
    let models: Vec<&Seen> = measured.models.iter().collect();
    let mut errors = vec![
        Part::picture(by_row(&models, subject.noise)),
        Part::picture(maps(&models, subject.convention)),
        Part::picture(histograms(&models, subject.noise)),
    ];
    for seen in &models {
        let poses: Vec<_> = seen.deviations.iter().map(|d| d.pose).collect();
        let arrows = Displacements::of(seen, subject.mechanism);
        errors.extend(drawing(subject.mechanism, &poses, Some(&arrows), &[]).map(Part::drawing));
    }
    let mut sections = vec![Section { id: "errors", title: "Where it was wrong, and what is left", parts: errors }];
    if let Some(calibrated) = models.first() {
        let residuals: Vec<(usize, &[f64])> =
            calibrated.deviations.iter().map(|d| (d.row, d.joints.as_slice())).collect();
        let mut marked: Vec<usize> = gross(&residuals);
        marked.extend(&found.outliers);
        let layers = [Layer { name: &calibrated.name, colour: 0, residuals }];
        let strips = strips(measured.data, subject.mechanism.joints(), &layers, &marked);
        let parts = strips.into_iter().map(Part::picture).collect();
        sections.push(Section { id: "legs", title: "What is left, leg by leg", parts });
    }
    let mut parameters: Vec<Part> =
        deviations(&c.parameters[..found.mechanism_parameters]).into_iter().map(Part::picture).collect();
    parameters.push(match c.weak.is_empty() {
        true => Part::Text("The data decide all directions of the parameters.".into()),
        false => Part::Table(
            vec!["direction that the data do not decide", "tolerance over its uncertainty"],
            c.weak.iter().map(|w| vec![w.text.clone(), format!("{:.2}", w.sigma)]).collect(),
        ),
    });
    parameters.extend(correlation(&found.parameters, &found.correlation()).map(Part::picture));
    sections.push(Section { id: "parameters", title: "Parameters", parts: parameters });
    sections.push(Section { id: "convergence", title: "Convergence", parts: vec![Part::picture(convergence(c))] });
    sections.push(Section { id: "numbers", title: "All numbers", parts: vec![Part::Lines(printed.to_owned())] });
    let mut lead: Vec<String> = c.verdict.reasons.iter().chain(&c.verdict.warnings).cloned().collect();
    if !c.verdict.trusted {
        lead.push(format!("What to do: {}", text::WHAT_IS_WRONG));
    }
    Page {
        title: format!("{}: calibration", c.mechanism.name()),
        verdict: format!("{verdict}. {summary}"),
        tone,
        numbers: numbers(c),
        lead,
        sections,
        settings: subject.settings.clone(),
    }
}

fn numbers(c: &Calibration) -> Vec<(String, String)> {
    let held_out = c.held_out.as_ref().map(|h| h.rms).unwrap_or_default();
    let rows = [
        ("position error, as it was given", c.before.position.map(show_length)),
        ("position error, calibrated", c.after.position.map(show_length)),
        ("the same on rows not fitted", held_out.position.map(show_length)),
        ("angle error, as it was given", c.before.rotation.map(show_angle)),
        ("angle error, calibrated", c.after.rotation.map(show_angle)),
        ("the same on rows not fitted", held_out.rotation.map(show_angle)),
    ];
    rows.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))).collect()
}

/// Rows of which a joint lies far from the others of its leg.
fn gross(residuals: &[(usize, &[f64])]) -> Vec<usize> {
    let joints = residuals.first().map_or(0, |(_, r)| r.len());
    let mut rows = Vec::new();
    for joint in 0..joints {
        let mut sizes: Vec<f64> = residuals.iter().map(|(_, r)| r[joint].abs()).filter(|v| v.is_finite()).collect();
        sizes.sort_by(f64::total_cmp);
        // The median of the sizes of normal noise is 0.6745 sigma.
        let Some(sigma) = sizes.get(sizes.len() / 2).map(|m| m / 0.6745).filter(|s| *s > 0.0) else { continue };
        let far = residuals.iter().filter(|(_, r)| r[joint].abs() > GROSS * sigma);
        rows.extend(far.map(|(row, _)| *row));
    }
    rows.sort_unstable();
    rows.dedup();
    rows
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

#[cfg(test)]
mod tests {
    use super::gross;

    #[test]
    fn a_row_far_from_its_neighbours_is_marked() {
        let mut values: Vec<Vec<f64>> = (0..40).map(|k| vec![f64::from(k % 5 - 2), f64::from(k % 3 - 1)]).collect();
        values[7][1] = -30.0;
        let residuals: Vec<(usize, &[f64])> = values.iter().enumerate().map(|(k, v)| (k + 100, v.as_slice())).collect();
        assert_eq!(gross(&residuals), [107]);
    }
}
