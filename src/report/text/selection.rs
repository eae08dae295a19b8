//! Text output of `select`.

use super::settlement::{CampaignLimits, campaign_limits};
use super::{heading, table};
use crate::observability::Scaling;
use crate::selection::{ChosenSet, Requirement};
use crate::units::{show_angle, show_length};

/// Results of `select`.
pub struct Selection<'a> {
    /// Name of the mechanism.
    pub title: &'a str,
    /// The choice.
    pub report: &'a ChosenSet,
    /// Units of the index.
    pub scaling: Scaling,
    /// Name of the selector.
    pub selector: &'a str,
    /// How many of the poses were given.
    pub given: usize,
    /// Choices for other numbers of poses.
    pub table: &'a [ChosenSet],
    /// Required accuracy, if any.
    pub requirement: Option<&'a Requirement>,
    /// Detection limits of a diagnosis with these poses, if requested.
    pub limits: Option<&'a CampaignLimits>,
    /// Where the poses were written, if they were.
    pub file: Option<String>,
}

/// Least part by which a pose more should lower the predicted error.
const PAYS: f64 = 0.01;

/// Text output of `select`; the last line is the result in one sentence.
pub fn selection(s: &Selection<'_>) -> String {
    let r = s.report;
    let new = r.poses.len() - s.given;
    let given = if s.given > 0 { format!(", {} given and {new} new", s.given) } else { String::new() };
    let mut text = format!(
        "{}\n{} poses{given} from {} candidates, {}, {} iterations\n\n",
        heading(s.title),
        r.poses.len(),
        r.candidates,
        s.selector,
        r.iterations
    );
    if !s.table.is_empty() {
        let rows: Vec<Vec<String>> = s.table.iter().map(number_row).collect();
        text += &table(&["poses", r.index.as_str(), "efficiency", "position", "rotation"], &rows);
        text += "(position and rotation: predicted RMS error of the calibrated pose)\n";
        if let Some(n) = pays_until(s.table) {
            text += &format!(
                "Beyond {n} poses, each additional one lowers the predicted position error by less than \
                              1 %.\n"
            );
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
            "no set of {} of these candidates is better than {bound:.6e}: certified efficiency {:.2} %\n",
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
    if let Some(limits) = s.limits {
        text += &format!("\n{}", campaign_limits(limits));
    }
    text += &format!("\n{}", next_step(s));
    text
}

/// What to do with a choice, in a sentence.
pub(in crate::report) fn next_step(s: &Selection<'_>) -> String {
    let new = s.report.poses.len() - s.given;
    let then = if s.limits.is_some() { "diagnose" } else { "calibrate" };
    match &s.file {
        Some(file) => format!("Measure the {new} poses of {file} in this order, then: paracal {then}"),
        None => {
            format!("Nothing was written: add -o poses.csv for the {new} poses and the joints to command, then measure")
        }
    }
}

/// A row of the table of numbers of poses: number, index, efficiency, predicted errors.
fn number_row(r: &ChosenSet) -> Vec<String> {
    let e = r.forecast.as_ref().map(|f| f.error);
    vec![
        r.poses.len().to_string(),
        format!("{:.4e}", r.value),
        r.efficiency.map_or_else(|| "-".into(), |e| format!("{:.1} %", 100.0 * e)),
        e.map_or_else(|| "-".into(), |e| show_length(e.position_rms)),
        e.map_or_else(|| "-".into(), |e| show_angle(e.rotation_rms)),
    ]
}

/// The first number of poses from which the predicted error falls by less than a hundredth for each pose more.
fn pays_until(table: &[ChosenSet]) -> Option<usize> {
    let errors: Vec<(usize, f64)> =
        table.iter().filter_map(|r| Some((r.poses.len(), r.forecast.as_ref()?.error.position_rms))).collect();
    let ahead = 5;
    errors.windows(ahead + 1).find(|w| w[ahead].1 > w[0].1 * (1.0 - PAYS).powi(ahead as i32)).map(|w| w[0].0)
}
