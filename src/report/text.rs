//! Tables and sentences for a terminal of 80 columns.

use nalgebra::Vector3;

use crate::identification::{Calibration, ErrorSummary, Estimate, ModelErrors, WeakDirection};
use crate::mechanism::{Mechanism, Survey};
use crate::observability::Scaling;
use crate::pose::PoseConvention;
use crate::selection::{Prospect, Report, Requirement};
use crate::units::{Dimension, fixed, show_angle, show_length, show_probability, three_digits};

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

/// Deviations of the parameters from the file with their σ: a line of each for a leg, in mm.
fn parameter_table(parameters: &[Estimate]) -> String {
    let per_leg = parameters.iter().take_while(|p| p.spec.name.ends_with('1')).count();
    let grid = per_leg > 0
        && parameters.len().is_multiple_of(per_leg)
        && per_leg <= 8
        && parameters.iter().all(|p| p.spec.dimension == Dimension::Length);
    if !grid {
        let row = |p: &Estimate| {
            let sigma = p.sigma.map_or_else(|| "?".into(), |s| format!("{s:.3e}"));
            let deviation = format!("{:+.6e}", p.value - p.start);
            vec![p.spec.name.clone(), format!("{:.9}", p.value), deviation, sigma, p.spec.dimension.si().into()]
        };
        let rows: Vec<Vec<String>> = parameters.iter().map(row).collect();
        return table(&["parameter", "value", "deviation", "sigma", "unit"], &rows);
    }
    let names: Vec<String> = parameters[..per_leg].iter().map(|p| p.spec.name.trim_end_matches('1').into()).collect();
    let mut header = vec!["leg"];
    header.extend(names.iter().map(String::as_str));
    let mut rows = Vec::new();
    for (leg, chunk) in parameters.chunks(per_leg).enumerate() {
        let deviations = chunk.iter().map(|p| format!("{:+.4}", 1e3 * (p.value - p.start)));
        rows.push(std::iter::once((leg + 1).to_string()).chain(deviations).collect());
        let sigmas = chunk.iter().map(|p| p.sigma.map_or_else(|| "?".into(), |s| format!("~{:.4}", 1e3 * s)));
        rows.push(std::iter::once(String::new()).chain(sigmas).collect());
    }
    format!("Deviation from the file and its 1 sigma (~), mm\n{}", table(&header, &rows))
}

/// What `calibrate` prints; the last line is the result in one sentence.
pub fn calibration(c: &Calibration, title: &str, kind: &str, identifier: &str) -> String {
    let found = &c.identification;
    let n = found.mechanism_parameters;
    let samples = found.poses.len();
    let prior = if found.prior { "tolerances as prior" } else { "no prior" };
    let mut text = format!("{title}\n{samples} samples ({kind}), {identifier}, {prior}\n\n");
    text += &parameter_table(&found.parameters[..n]);
    if found.parameters.len() > n {
        text += "\nIdentified target coordinates\n";
        text += &parameter_table(&found.parameters[n..]);
    }
    text += "\n";
    let mut rows = vec![errors_row("before", &c.before), errors_row("fitted", &c.after)];
    if let Some(h) = &c.held_out {
        let gross = if found.outliers.is_empty() { "" } else { ", gross errors too" };
        rows.push(errors_row(&format!("held out ({} rows{gross})", h.samples), &h.rms));
    }
    if let Some(p) = &c.predicted {
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
        text += &format!(
            "\nFrames: the base stands {} away and turned by {} in the tracker's frame;\n        the target sits {} away and turned by {} on the platform.\n",
            show_length(b.position.norm()),
            show_angle(crate::pose::rotation_vector(&b.rotation).norm()),
            show_length(t.position.norm()),
            show_angle(crate::pose::rotation_vector(&t.rotation).norm()),
        );
    }
    text += &weak_directions(c);
    let implausible = &c.plausibility.implausible;
    for p in implausible.iter().take(SHOWN) {
        let (deviation, tolerance) = (1e3 * p.deviation, 1e3 * p.tolerance);
        text += &format!("Implausible: {} deviates by {deviation:+.3} mm (tolerance {tolerance:.3} mm).\n", p.name);
    }
    if implausible.len() > SHOWN {
        text += &format!("and {} more implausible parameters (--json lists all)\n", implausible.len() - SHOWN);
    }
    text += &match c.verdict.trusted {
        true => "\nThe result can be trusted.\n".to_owned(),
        false => format!("\nDo not trust this result: {}.\n", c.verdict.reasons.join("; ")),
    };
    text + &result_line(c)
}

fn weak_directions(c: &Calibration) -> String {
    if c.weak.is_empty() {
        return String::new();
    }
    let mut text = format!(
        "\nThe data decide {} of {} directions; not decided (tolerance over sigma from the data):\n",
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
    } else if let Some(p) = &c.predicted {
        text += "Values along these directions come from the tolerances; poses inside the workspace are still\n";
        text += &format!("predicted to {} and {}.\n", show_length(p.position_rms), show_angle(p.rotation_rms));
    }
    text
}

fn result_line(c: &Calibration) -> String {
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

/// What `evaluate` prints.
pub fn evaluation(e: &ModelErrors, title: &str) -> String {
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

/// What `inspect` found.
pub struct Inspection<'a> {
    /// The mechanism.
    pub mechanism: &'a dyn Mechanism,
    /// How its poses are written.
    pub convention: &'a PoseConvention,
    /// Platform points by leg, platform frame, m.
    pub platform: Vec<(usize, Vector3<f64>)>,
    /// Base points by leg, base frame, m.
    pub base: Vec<(usize, Vector3<f64>)>,
    /// Lengths of the legs as the file states them, m.
    pub lengths: Vec<f64>,
    /// Joints at home.
    pub home_joints: Vec<f64>,
    /// Mean radius of the platform points, m.
    pub radius: f64,
    /// Condition of `J₁` at home.
    pub home_condition: f64,
    /// Extremes over the workspace.
    pub survey: Option<Survey>,
    /// What 20 poses could tell.
    pub prospect: Option<Prospect>,
    /// Directions that they would not decide.
    pub weak: Vec<WeakDirection>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// What `inspect` prints.
pub fn inspection(i: &Inspection<'_>) -> String {
    let mm = |v: f64| fixed(1e3 * v, 3);
    let point = |points: &[(usize, Vector3<f64>)], k: usize| {
        points
            .iter()
            .find(|(leg, _)| *leg == k)
            .map_or_else(|| "-".into(), |(_, p)| format!("{} {} {}", mm(p.x), mm(p.y), mm(p.z)))
    };
    let mut header = vec!["joint", "platform point", "base point", "home"];
    if i.survey.is_some() {
        header.push("over the workspace");
    }
    let row = |(k, joint): (usize, &crate::mechanism::JointSpec)| {
        let mut cells = vec![joint.name.clone(), point(&i.platform, k), point(&i.base, k), mm(i.home_joints[k])];
        cells.extend(i.survey.as_ref().map(|s| format!("{} {}", mm(s.joint_range[k][0]), mm(s.joint_range[k][1]))));
        cells
    };
    let rows: Vec<Vec<String>> = i.mechanism.joints().iter().enumerate().map(row).collect();
    let mut text = format!(
        "{}: {} parameters\n\nmm\n{}",
        i.mechanism.name(),
        i.mechanism.parameters().len(),
        table(&header, &rows)
    );
    let q = i.convention.coordinates(&i.mechanism.home());
    text += &format!(
        "\nHome: x {} y {} z {} mm, rx {} ry {} rz {} deg\n",
        mm(q[0]),
        mm(q[1]),
        mm(q[2]),
        fixed(q[3].to_degrees(), 5),
        fixed(q[4].to_degrees(), 5),
        fixed(q[5].to_degrees(), 5)
    );
    text += &format!(
        "Condition of the mechanism (angles times the radius, {}): {:.2} at home",
        show_length(i.radius),
        i.home_condition
    );
    text += &i
        .survey
        .as_ref()
        .map_or_else(|| "\n".into(), |s| format!(", at most {:.2} over the workspace\n", s.worst_condition));
    if let Some(p) = &i.prospect {
        text += &prospect(i.mechanism, p, &i.weak);
    }
    for w in &i.warnings {
        text += &format!("\nNote: {w}.");
    }
    text.trim_end().to_owned()
}

fn prospect(mechanism: &dyn Mechanism, p: &Prospect, weak: &[WeakDirection]) -> String {
    let f = &p.forecast;
    let variance = |(k, scale): (usize, &f64)| f.covariance[(k, k)] * scale * scale;
    let total = mechanism.parameters().len();
    let rms = (p.scale.iter().enumerate().map(variance).sum::<f64>() / total as f64).sqrt();
    let mut text = format!("\nWhat {} well chosen poses of the workspace could tell:\n", p.poses.len());
    text += &format!("  {} of {total} parameter directions", total - weak.len());
    text += &format!(
        ", parameters to {} (RMS sigma{})\n",
        show_length(rms),
        if f.prior { ", tolerances as prior" } else { "" }
    );
    let e = &f.error;
    text +=
        &format!("  poses in the workspace to {} and {}\n", show_length(e.position_rms), show_angle(e.rotation_rms));
    for w in weak.iter().take(SHOWN) {
        text += &format!("  not decided ({}): {}\n", three_digits(w.sigma), w.text);
    }
    if weak.len() > SHOWN {
        text += &format!("  and {} more\n", weak.len() - SHOWN);
    }
    text
}

/// What `select` chose.
pub struct Selection<'a> {
    /// Name of the mechanism.
    pub title: &'a str,
    /// The choice.
    pub report: &'a Report,
    /// Units of the index.
    pub scaling: Scaling,
    /// Name of the selector.
    pub selector: &'a str,
    /// How many of the poses were given.
    pub given: usize,
    /// Choices for other numbers of poses.
    pub table: &'a [Report],
    /// What was required.
    pub requirement: Option<&'a Requirement>,
    /// Where the poses were written.
    pub file: &'a str,
}

/// Least part by which a pose more should lower the predicted error.
const PAYS: f64 = 0.01;

/// What `select` prints; the last line is the result in one sentence.
pub fn selection(s: &Selection<'_>) -> String {
    let r = s.report;
    let new = r.poses.len() - s.given;
    let given = if s.given > 0 { format!(", {} given and {new} new", s.given) } else { String::new() };
    let mut text = format!(
        "{}\n{} poses{given} from {} candidates, {}, {} iterations\n\n",
        s.title,
        r.poses.len(),
        r.candidates,
        s.selector,
        r.iterations
    );
    if !s.table.is_empty() {
        let row = |r: &Report| {
            let e = r.forecast.as_ref().map(|f| f.error);
            vec![
                r.poses.len().to_string(),
                format!("{:.4e}", r.value),
                r.efficiency.map_or_else(|| "-".into(), |e| format!("{:.1} %", 100.0 * e)),
                e.map_or_else(|| "-".into(), |e| show_length(e.position_rms)),
                e.map_or_else(|| "-".into(), |e| show_angle(e.rotation_rms)),
            ]
        };
        let rows: Vec<Vec<String>> = s.table.iter().map(row).collect();
        text += &table(&["poses", r.index.as_str(), "efficiency", "position", "rotation"], &rows);
        text += "(position and rotation: predicted RMS error of the calibrated pose)\n";
        if let Some(n) = pays_until(s.table) {
            text += &format!("From {n} poses on, one more lowers the predicted position error by less than 1 %.\n");
        }
        text += "\n";
    }
    let units = match s.scaling {
        Scaling::Paper => "mm and rad",
        Scaling::Whitened if r.index == "pose-error" => "in units of the noise, smaller is better",
        Scaling::Whitened => "tolerance over noise",
    };
    text += &format!("{} = {:.6e} ({units})\n", r.index, r.value);
    text += &match (r.bound, r.efficiency) {
        (Some(bound), Some(efficiency)) => format!(
            "no set of {} of these candidates passes {bound:.6e}: certified efficiency {:.2} %\n",
            r.poses.len(),
            100.0 * efficiency
        ),
        _ => format!("no bound is known for {}\n", r.index),
    };
    if let Some(f) = &r.forecast {
        let e = &f.error;
        let prior = if f.prior { ", with tolerances as prior" } else { "" };
        text += &format!(
            "predicted error of the calibrated pose: {} and {} RMS, at most {} and {}{prior}\n",
            show_length(e.position_rms),
            show_angle(e.rotation_rms),
            show_length(e.position_max),
            show_angle(e.rotation_max),
        );
    }
    if s.requirement.is_some() {
        text += &format!("{} poses are the fewest found that meet the requirement\n", r.poses.len());
    }
    text += &format!("\nMeasure the {new} poses of {}, then: paracal calibrate", s.file);
    text
}

/// The first number of poses from which the predicted error falls by less than a hundredth for each pose more.
fn pays_until(table: &[Report]) -> Option<usize> {
    let errors: Vec<(usize, f64)> =
        table.iter().filter_map(|r| Some((r.poses.len(), r.forecast.as_ref()?.error.position_rms))).collect();
    let ahead = 5;
    errors.windows(ahead + 1).find(|w| w[ahead].1 > w[0].1 * (1.0 - PAYS).powi(ahead as i32)).map(|w| w[0].0)
}
