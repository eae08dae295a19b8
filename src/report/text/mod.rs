//! Tables and sentences for a terminal of 80 columns.

mod diagnosis;
mod inspection;
mod meaning;
mod selection;
mod settlement;

pub(in crate::report) use diagnosis::understated;
pub use diagnosis::{diagnosis, verdict};
pub use inspection::{Inspection, inspection};
pub(in crate::report) use meaning::meanings;
pub(in crate::report) use selection::next_step;
pub use selection::{Selection, selection};
pub use settlement::{CampaignLimits, campaign_limits, detection_limits, settlement};

use crate::identification::{Calibration, ErrorSummary, Estimate, ModelErrors};
use crate::pose::{Pose, rotation_vector};
use crate::report::in_the_drawing::in_the_drawing;
use crate::units::{Dimension, show_angle, show_length, show_probability, three_digits};

/// Advice for a calibration that must not be trusted.
pub(in crate::report) const WHAT_IS_WRONG: &str =
    "run `paracal diagnose` on the same two files: it names what the model or the file gets wrong.";

/// Long lists are cut after this many lines.
const SHOWN: usize = 6;

/// A table with right-aligned columns; the first column is left-aligned.
pub fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let columns = header.len();
    let width = |k: usize| {
        rows.iter().filter_map(|r| r.get(k)).map(|c| c.chars().count()).chain([header[k].chars().count()]).max()
    };
    let widths: Vec<usize> = (0..columns).map(|k| width(k).unwrap_or(0)).collect();
    let line = |cells: Vec<&str>| {
        let padded: Vec<String> = cells
            .iter()
            .zip(&widths)
            .enumerate()
            .map(|(k, (cell, w))| if k == 0 { format!("{cell:<w$}") } else { format!("{cell:>w$}") })
            .collect();
        format!("{}\n", padded.join("  ").trim_end())
    };
    let body = rows.iter().map(|r| line(r.iter().map(String::as_str).collect()));
    std::iter::once(line(header.to_vec())).chain(body).collect()
}

fn errors_row(name: &str, e: &ErrorSummary) -> Vec<String> {
    let shown = |v: Option<f64>, f: fn(f64) -> String| v.map_or_else(|| "-".into(), f);
    vec![name.into(), shown(e.position, show_length), shown(e.rotation, show_angle)]
}

/// How many leading parameters make a grid of legs (each with the same ones in the same order), and how many each leg
/// has; `(0, 1)` if they make none that fits the terminal.
fn leg_grid(parameters: &[Estimate]) -> (usize, usize) {
    let leg = |p: &Estimate| p.spec.role.leg();
    let per_leg = parameters.iter().take_while(|p| leg(p) == Some(0)).count();
    let count = parameters.iter().take_while(|p| leg(p).is_some()).count();
    let (grid, rest) = parameters.split_at(count);
    let kind = |p: &Estimate| {
        let number = leg(p).map_or(0, |l| l + 1).to_string();
        p.spec.name.strip_suffix(&number).map(|stem| (stem.to_owned(), p.spec.dimension))
    };
    let alike = |(k, p): (usize, &Estimate)| {
        leg(p) == Some(k / per_leg) && kind(p).is_some() && kind(p) == kind(&parameters[k % per_leg])
    };
    let fits = (1..=9).contains(&per_leg)
        && count.is_multiple_of(per_leg)
        && grid.iter().enumerate().all(alike)
        && rest.iter().all(|p| leg(p).is_none());
    if fits { (count, per_leg) } else { (0, 1) }
}

/// Deviations of the parameters from the file with their σ: a line of each for a leg, then the others one by one.
fn parameter_table(parameters: &[Estimate]) -> String {
    let (count, per_leg) = leg_grid(parameters);
    let (grid, rest) = parameters.split_at(count);
    let mut text = if grid.is_empty() { String::new() } else { leg_table(grid, per_leg) };
    if !rest.is_empty() {
        let row = |p: &Estimate| {
            let sigma = p.sigma.map_or_else(|| "?".into(), |s| format!("{s:.3e}"));
            let deviation = format!("{:+.6e}", p.value - p.start);
            vec![p.spec.name.clone(), format!("{:.9}", p.value), deviation, sigma, p.spec.dimension.si().into()]
        };
        let rows: Vec<Vec<String>> = rest.iter().map(row).collect();
        if !grid.is_empty() {
            text.push('\n');
        }
        text += &table(&["parameter", "value", "deviation", "sigma", "unit"], &rows);
    }
    text
}

/// The table of the legs. Its unit stands above it, or behind the names of the columns if these differ in dimension.
fn leg_table(grid: &[Estimate], per_leg: usize) -> String {
    let first = &grid[..per_leg];
    let shared = first.iter().all(|p| p.spec.dimension == first[0].spec.dimension);
    let name = |p: &Estimate| {
        let stem = p.spec.name.strip_suffix('1').unwrap_or(&p.spec.name);
        let (unit, _) = p.spec.dimension.in_tables();
        if shared { stem.to_owned() } else { format!("{stem} ({unit})") }
    };
    let names: Vec<String> = first.iter().map(name).collect();
    let mut header = vec!["leg"];
    header.extend(names.iter().map(String::as_str));
    // A ten thousandth of a millimetre at an arm of a metre is some 1e-5 degrees.
    let shown = |v: f64, dimension: Dimension| {
        let (_, per_si) = dimension.in_tables();
        (per_si * v, if dimension == Dimension::Length { 4 } else { 5 })
    };
    let mut rows = Vec::new();
    for (leg, chunk) in grid.chunks(per_leg).enumerate() {
        let deviations = chunk.iter().map(|p| {
            let (v, decimals) = shown(p.value - p.start, p.spec.dimension);
            format!("{v:+.decimals$}")
        });
        rows.push(std::iter::once((leg + 1).to_string()).chain(deviations).collect());
        let sigmas = chunk.iter().map(|p| {
            let text = |s: f64| {
                let (v, decimals) = shown(s, p.spec.dimension);
                format!("~{v:.decimals$}")
            };
            p.sigma.map_or_else(|| "?".into(), text)
        });
        rows.push(std::iter::once(String::new()).chain(sigmas).collect());
    }
    let unit = if shared { format!(", {}", first[0].spec.dimension.in_tables().0) } else { String::new() };
    format!("Deviation from the mechanism file; 1 sigma below it (~){unit}\n{}", table(&header, &rows))
}

/// A name in the first line of a text: it has one line, whatever the file says.
pub(crate) fn heading(name: &str) -> String {
    name.replace(['\n', '\r'], " ")
}

/// Text output of `calibrate`; the last line is the result in one sentence.
pub fn calibration(c: &Calibration) -> String {
    let found = &c.identification;
    let n = found.mechanism_parameters;
    let samples = found.poses.len();
    let prior = if found.prior { "tolerances as prior" } else { "no prior" };
    let title = heading(c.mechanism.name());
    let mut text = format!("{title}\n{samples} samples ({}), {}, {prior}\n\n", c.measurement, c.identifier);
    let parameters = in_the_drawing(c);
    text += &parameter_table(&parameters[..n]);
    if parameters.len() > n {
        text += &format!("\n{}\n", c.nuisance_heading);
        text += &parameter_table(&parameters[n..]);
    }
    text += "\n";
    let mut rows = vec![errors_row("before", &c.before), errors_row("fitted", &c.after)];
    if let Some(h) = &c.held_out {
        let gross = if found.outliers.is_empty() { "" } else { ", including gross errors" };
        rows.push(errors_row(&format!("held out ({} rows{gross})", h.samples), &h.rms));
    }
    if let Some(p) = c.predicted.as_ref().filter(|_| c.verdict.trusted) {
        let e = ErrorSummary { position: Some(p.position_rms), rotation: Some(p.rotation_rms) };
        rows.push(errors_row(
            if c.workspace.is_some() { "model error, workspace" } else { "model error, these poses" },
            &e,
        ));
    }
    text += &table(&["RMS error", "position", "rotation"], &rows);
    if let Some(p) = found.misfit.p_value() {
        let scale = found.misfit.scale().unwrap_or(f64::NAN);
        let free = found.misfit.degrees_of_freedom;
        text += &format!(
            "\nResiduals are {} times the stated noise (chi-square {:.1}, {free} degrees of freedom, p {}).\n",
            three_digits(scale),
            found.misfit.chi_square,
            show_probability(p)
        );
    }
    if c.registration.applied {
        let (b, t) = (&c.plausibility.base, &c.plausibility.target);
        let turned = |p: &Pose| show_angle(rotation_vector(&p.rotation).norm());
        let away = show_length(b.position.norm());
        text += &format!("\nFrames: the base is {away} away and rotated by {} in the tracker's frame", turned(b));
        if *t != Pose::identity() {
            let off = show_length(t.position.norm());
            text += &format!(";\n        the target is offset by {off} and rotated by {} on the platform", turned(t));
        }
        text += ".\n        The calibrated model is in the frames of the measurement (commands take --frame base for\n        \
                 the other); the deviations above are those of the machine, without these motions.\n";
    }
    text += &weak_directions(c);
    let implausible = &c.plausibility.implausible;
    for p in implausible.iter().take(SHOWN) {
        let (unit, per_si) = p.dimension.in_tables();
        let (deviation, tolerance) = (per_si * p.deviation, per_si * p.tolerance);
        text +=
            &format!("Implausible: {} deviates by {deviation:+.3} {unit} (tolerance {tolerance:.3} {unit}).\n", p.name);
    }
    if implausible.len() > SHOWN {
        text += &format!("and {} more implausible parameters (--json lists all)\n", implausible.len() - SHOWN);
    }
    text += &match c.verdict.trusted {
        true => format!("\n{}.\n", trusted(c)),
        false => {
            format!("\nDo not trust this result: {}.\nTo find out why, {WHAT_IS_WRONG}\n", c.verdict.reasons.join("; "))
        }
    };
    text + &result_line(c)
}

/// That a result can be trusted, and to how much.
pub(in crate::report) fn trusted(c: &Calibration) -> String {
    let over = if c.workspace.is_some() { "over the workspace" } else { "at the measured poses" };
    let Some(p) = &c.predicted else { return "Trusted".into() };
    format!("Trusted: poses to {} and {} (1 sigma {over})", show_length(p.position_rms), show_angle(p.rotation_rms))
}

fn weak_directions(c: &Calibration) -> String {
    if c.weak.is_empty() {
        return String::new();
    }
    let mut text = format!(
        "\nThe data determine {} of {} directions; not determined (tolerance over sigma from the data):\n",
        c.identification.mechanism_parameters - c.weak.len(),
        c.identification.mechanism_parameters
    );
    for w in c.weak.iter().take(SHOWN) {
        text += &format!("  {:>8}  {}\n", three_digits(w.sigma), w.text);
    }
    if c.weak.len() > SHOWN {
        text += &format!("  and {} more (--json lists all)\n", c.weak.len() - SHOWN);
    }
    if !c.identification.prior {
        text += "No prior was used: along these directions the values are as uncertain as their sigma says.\n";
    } else if let Some(p) = c.predicted.as_ref().filter(|_| c.verdict.trusted) {
        text += "Values along these directions come from the tolerances; poses inside the workspace are still\n";
        text += &format!("predicted to {} and {}.\n", show_length(p.position_rms), show_angle(p.rotation_rms));
    }
    text
}

/// The result in one sentence.
pub(in crate::report) fn result_line(c: &Calibration) -> String {
    let measured = |e: &ErrorSummary| match (e.position, e.rotation) {
        (Some(p), _) => show_length(p),
        (None, Some(r)) => show_angle(r),
        _ => "-".into(),
    };
    let held =
        c.held_out.as_ref().map_or_else(|| "not held out".into(), |h| format!("{} (held out)", measured(&h.rms)));
    format!(
        "{} parameters, {} poses: RMS {} -> {} (fitted), {held}",
        c.parameters.len(),
        c.identification.poses.len(),
        measured(&c.before),
        measured(&c.after),
    )
}

/// Text output of `evaluate`.
pub fn evaluation(e: &ModelErrors, title: &str) -> String {
    let title = heading(title);
    let rows = [errors_row("RMS", &e.rms()), errors_row("mean", &e.mean()), errors_row("largest", &e.max())];
    let worst = e.samples.iter().max_by(|a, b| a.position.unwrap_or(0.0).total_cmp(&b.position.unwrap_or(0.0)));
    let mut text = format!(
        "{title}: {} rows, nothing fitted\n\n{}",
        e.samples.len(),
        table(&["error", "position", "rotation"], &rows)
    );
    if let Some((row, p)) = worst.and_then(|w| Some((w.row, w.position?))) {
        text += &format!("\nThe largest position error, {}, is in data row {row}.", show_length(p));
    }
    text
}
