//! The diagnosis in words.

use super::settlement::limit_table;
use super::{errors_row, heading, table};
use crate::diagnosis::{COORDINATES, Cause, Diagnosis, Rival, Unknown, UnknownTest, Verdict};
use crate::effect::ActsOn;
use crate::measurement::{DataRow, Frames};
use crate::pose::{Pose, rotation_vector};
use crate::units::{Dimension, shortened, show_angle, show_length, show_probability, show_quantity, three_digits};

/// Tables and sentences of a diagnosis. `title` is the name of the mechanism.
pub fn diagnosis(d: &Diagnosis, title: &str) -> String {
    let title = heading(title);
    let mut text = format!("{title}: {} samples\n\n{}\n", d.samples, verdict(d));
    if d.verdict == Verdict::Misread || d.values.is_empty() {
        return text;
    }
    for cause in &d.causes {
        text += &format!("\n{}", cause_text(d, cause));
    }
    if let Some(unknown) = &d.unknown {
        text += &format!("\n{}", unknown_text(d, unknown));
    }
    text += &format!("\n{}", errors_text(d));
    if !d.outlier_rows.is_empty() {
        let rows: Vec<String> = d.outlier_rows.iter().map(DataRow::to_string).collect();
        text += &format!("\ngross errors, left out: data rows {}\n", shortened(&rows));
    }
    if let Some(n) = &d.noise_varies {
        text += &format!(
            "\nthe noise varies with {}: {} times as large at the end of its range as at the beginning (p {})\n",
            n.covariate,
            three_digits(n.ratio),
            show_probability(n.p_value)
        );
    }
    if let Some(rho) = d.correlation {
        text += &format!(
            "\nsuccessive rows are correlated ({rho:.2}); tests count {:.0} % of the rows as independent\n",
            100.0 * (1.0 - rho) / (1.0 + rho)
        );
    }
    text += &frames_text(d);
    text += &lists(d);
    text
}

/// A target nearer to its place than this, m, was not moved.
const UNMOVED: f64 = 1e-9;

/// Where base and target are, if the data are in the frame of an instrument.
fn frames_text(d: &Diagnosis) -> String {
    let Frames { base, target } = &d.frames;
    if *base == Pose::identity() && *target == Pose::identity() {
        return String::new();
    }
    let place = |pose: &Pose| {
        let turn = show_angle(rotation_vector(&pose.rotation).norm());
        [show_length(pose.position.norm()), turn]
    };
    let [away, turned] = place(base);
    let mut lines = vec![format!("the base is {away} away and rotated by {turned} in the tracker's frame")];
    if target.position.norm() > UNMOVED {
        let [offset, turned] = place(target);
        lines.push(format!("the target is offset by {offset} and rotated by {turned} on the platform"));
    }
    if !d.causes.is_empty() {
        lines.push("causes act in the base frame; an extended model takes poses in the tracker's frame".into());
    }
    format!("\nFrames: {}.\n", lines.join(";\n        "))
}

/// ` at leg 3`, or the coordinate that a joint stands for.
fn at_leg(d: &Diagnosis, leg: Option<usize>) -> String {
    let Some(leg) = leg else { return String::new() };
    match d.joints.get(leg).and_then(|name| name.strip_prefix("cmd_")) {
        Some(coordinate) => format!(" in {coordinate}"),
        None => format!(" at leg {}", leg + 1),
    }
}

fn name_of(d: &Diagnosis, effect: &str, leg: Option<usize>) -> String {
    format!("{effect}{}", at_leg(d, leg))
}

/// Residual over the stated noise from which on it is worth a word.
const LOUD: f64 = 1.3;

/// How many times the stated noise is left, of positions or of angles, if noise was stated and it is far more.
pub(in crate::report) fn understated(d: &Diagnosis) -> Option<f64> {
    let g = &d.gain;
    let kinds = [(d.after.position, g.noise_floor_position), (d.after.rotation, g.noise_floor_rotation)];
    let times = kinds.into_iter().filter_map(|(left, stated)| Some(left? / stated?));
    times.max_by(f64::total_cmp).filter(|times| *times > LOUD)
}

/// The verdict in a sentence or two.
pub fn verdict(d: &Diagnosis) -> String {
    let names: Vec<String> = d.causes.iter().map(|c| name_of(d, &c.effect, c.leg)).collect();
    let names = names.join(" and ");
    match d.verdict {
        Verdict::Clean => match understated(d) {
            Some(times) => format!(
                "CLEAN: the residuals are consistent with noise, but with {} times the stated noise: either that is \
                 understated, or something changes that was not recorded.",
                three_digits(times)
            ),
            None => "CLEAN: the residuals are consistent with noise.".into(),
        },
        Verdict::Named => format!("NAMED: {names}."),
        Verdict::Tied => {
            let rivals: Vec<String> = d.causes.iter().flat_map(|c| &c.tied_with).map(Rival::label).collect();
            format!("TIED: {names}, but these data do not exclude {}.", rivals.join(", "))
        }
        Verdict::Unknown => {
            let what = d.unknown.as_ref().map_or_else(String::new, |u| where_it_is(d, u));
            let beside = if names.is_empty() { String::new() } else { format!(" in addition to {names}") };
            format!("UNKNOWN{beside}: no effect in the catalogue explains the remaining error{what}.")
        }
        Verdict::Undecided => {
            format!("UNDECIDED: {}.", d.undecided.as_deref().unwrap_or("these data cannot tell"))
        }
        Verdict::Misread => d.misread.as_ref().map_or_else(String::new, |m| {
            let rivals = match m.tied_with.is_empty() {
                true => String::new(),
                false => format!("\nJust as likely: {}.", m.tied_with.join("; ")),
            };
            format!(
                "MISREAD ({}): {}.\nRead that way, the data fit {} times better. Nothing was fitted; correct the file \
                 and try again.\nAs the file stands, the mechanism does not fit {} of {} rows.{rivals}",
                m.reading,
                m.detail,
                times_better(m.factor),
                m.rows_failing,
                d.samples
            )
        }),
    }
}

/// How much better a reading fits. A wrong one leaves a fit so badly posed that digits of a large factor mean nothing.
fn times_better(factor: f64) -> String {
    const MANY: f64 = 1000.0;
    if factor > MANY { format!("more than {MANY}") } else { three_digits(factor) }
}

fn where_it_is(d: &Diagnosis, u: &Unknown) -> String {
    let place = match u.coordinate {
        Some(k) => format!(" in {} of the platform as it is seen", COORDINATES[k]),
        None => at_leg(d, u.leg),
    };
    let times = u.size.map_or_else(|| "far more".into(), |s| format!("{} times", three_digits(s)));
    match (&u.covariate, u.test) {
        (Some(covariate), UnknownTest::Patchwork) => {
            format!(", which changes with {covariate}; the causes above only mimic it")
        }
        (Some(covariate), _) => format!(", which depends on {covariate}{place}"),
        (None, UnknownTest::Misfit) => {
            ", because the data do not fit the mechanism at all: check the file and the mechanism".into()
        }
        (None, UnknownTest::Extrapolation) => {
            ": the names that fit make rows that were not fitted worse, so that none is kept".into()
        }
        (None, UnknownTest::Scatter) => format!(", which scatters{place} and depends on nothing that was recorded"),
        (None, UnknownTest::Repeats) => format!(", which is {times} the scatter of the samples that repeat each other"),
        (None, UnknownTest::Size) if u.p_value > RATIO_ALONE => {
            format!(": position noise over rotation noise is {times} off the stated ratio")
        }
        (None, _) => format!(
            ", which is {times} the stated noise: that is understated, or something changes that was not recorded"
        ),
    }
}

/// A size as likely as this is no excess of the noise; its ratio is.
const RATIO_ALONE: f64 = 1e-6;

/// A value of a covariate with its unit, or a number of rows.
fn shown(d: &Diagnosis, covariate: &str, value: f64) -> String {
    match d.environment.condition_kinds.of(covariate) {
        Some(kind) => kind.shown(value),
        None if COORDINATES.contains(&covariate) => {
            let length = COORDINATES[..3].contains(&covariate);
            show_quantity(value, if length { Dimension::Length } else { Dimension::Angle })
        }
        None if covariate == "row" => format!("{} rows", three_digits(value)),
        None => three_digits(value),
    }
}

fn unknown_text(d: &Diagnosis, u: &Unknown) -> String {
    let mut text = format!("unknown error{} (p {}", where_it_is(d, u), show_probability(u.p_value));
    if let Some(period) = u.period {
        text += &format!(", repeats every {}", shown(d, u.covariate.as_deref().unwrap_or("row"), period));
    }
    text += ")\n";
    if let (Some(size), false) = (u.size, u.dimension == Dimension::None) {
        text += &format!("  it is {} large", show_quantity(size, u.dimension));
        if let Some((name, at)) = u.covariate.as_ref().zip(u.from) {
            text += &format!(", from {name} = {} on", shown(d, name, at));
        }
        text += "\n";
    }
    if let Some(other) = &u.runner_up {
        text += &format!("  {other} explains nearly as much\n");
    }
    if !u.withdrawn.is_empty() {
        let why = match u.test {
            UnknownTest::Extrapolation => "with it rows that were not fitted would be missed by more",
            UnknownTest::Misfit => "its value is of no use in a model that does not fit",
            _ => "what is unknown explains more",
        };
        text += &format!("  withdrawn: {}, because {why}\n", u.withdrawn.join(" and "));
    }
    text
}

fn cause_text(d: &Diagnosis, c: &Cause) -> String {
    let place = c.row.map_or_else(String::new, |row| format!(" from data row {row} on"));
    let lag = c.lag.map(|lag| format!("{} min behind", three_digits(lag / 60.0)));
    let of: Vec<String> = c.of.iter().cloned().chain(lag).collect();
    let of = if of.is_empty() { String::new() } else { format!(" ({})", of.join(", ")) };
    let mut text = format!("{}{of}{place}: {}\n", name_of(d, &c.effect, c.leg), c.cause);
    let rows: Vec<Vec<String>> = c
        .parameters
        .iter()
        .map(|p| {
            let shown = |v: f64| show_quantity(v, p.dimension);
            vec![
                format!("  {}", p.name),
                shown(p.value),
                p.sigma.map_or_else(|| "not seen".into(), shown),
                shown(p.scale),
            ]
        })
        .collect();
    text += &table(&["  parameter", "value", "sigma", "usual size"], &rows);
    text += &format!(
        "  {} times the detection limit{}; p {}; evidence {} nats{}\n",
        three_digits(c.size_over_limit),
        if c.tentative { " (tentative)" } else { "" },
        show_probability(c.p_value),
        three_digits(c.evidence),
        if c.plausible { "" } else { implausible(c) },
    );
    for r in &c.tied_with {
        text += &format!(
            "  not excluded: {} ({} nats behind; separability {}, about 10 is needed)\n",
            r.parts().map(|part| name_of(d, &part.effect, part.leg)).collect::<Vec<_>>().join(" together with "),
            three_digits(r.log_bayes_factor),
            three_digits(r.separability)
        );
    }
    if !c.not_excluded.is_empty() {
        text += &format!(
            "  not excluded either, because their sensors are missing: {}; the name is tentative\n",
            c.not_excluded.join(", ")
        );
    }
    if c.acts_on == ActsOn::Measurement {
        text += "  it affects the readings, not the platform\n";
    }
    text + &format!("  what to do: {}\n", c.remedy)
}

/// Why the values of a cause are not plausible.
fn implausible(c: &Cause) -> &'static str {
    let large = c.parameters.iter().any(|p| p.value.abs() > 10.0 * p.scale);
    if large {
        "; the value is far outside the usual range"
    } else {
        "; nothing shrinks as it gets warmer: the value is not plausible, and something else may be behind it"
    }
}

fn errors_text(d: &Diagnosis) -> String {
    let g = &d.gain;
    let summary = |position, rotation| crate::identification::ErrorSummary { position, rotation };
    let mut rows = vec![errors_row("residual, parameters alone", &d.before)];
    let named = !d.causes.is_empty();
    if named {
        rows.push(errors_row("residual, with the causes", &d.after));
    }
    rows.push(errors_row("held out, parameters alone", &summary(g.position_before, g.rotation_before)));
    if named {
        rows.push(errors_row("held out, with the causes", &summary(g.position_after, g.rotation_after)));
        rows.push(errors_row("held out in blocks, parameters alone", &summary(g.blocked_position_before, None)));
        rows.push(errors_row("held out in blocks, with the causes", &summary(g.blocked_position_after, None)));
    }
    rows.push(errors_row("stated noise", &summary(g.noise_floor_position, g.noise_floor_rotation)));
    let mut text = table(&["RMS of vector lengths", "position", "rotation"], &rows);
    if let (true, Some(before), Some(after)) = (named, g.position_before, g.position_after) {
        let turned = g.rotation_before.zip(g.rotation_after);
        let turned = turned.map_or_else(String::new, |(b, a)| {
            format!(
                " and the rotation error by \
                                                                       {}",
                show_angle(b - a)
            )
        });
        text += &format!(
            "on held-out rows, modelling the causes reduces the position error by {}{turned}\n",
            show_length(before - after)
        );
    }
    text
}

fn lists(d: &Diagnosis) -> String {
    let mut text = String::new();
    if !d.not_found.is_empty() {
        text += "\ntested and not found; an effect of this size would have been detected with 95 % probability:\n";
        text += &limit_table(&d.not_found);
    }
    if !d.not_testable.is_empty() {
        text += "\nnot testable with these data:\n";
        // Effects that miss the same stand together.
        let mut groups: Vec<(String, Vec<&str>)> = Vec::new();
        for n in &d.not_testable {
            let needs = n.missing.join(", ");
            match groups.iter_mut().find(|(other, _)| *other == needs) {
                Some((_, effects)) => effects.push(&n.effect),
                None => groups.push((needs, vec![&n.effect])),
            }
        }
        for (needs, effects) in groups {
            text += &format!("  {}: needs {needs}\n", effects.join(", "));
        }
    }
    text
}
