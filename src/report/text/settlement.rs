//! Text output for measurements that settle a tie, and for the detection limits of a campaign.

use super::{heading, table};
use crate::diagnosis::{Diagnosis, MeasurementPlan, NotFound, NotTestable, TOLD_APART};
use crate::measurement::Noise;
use crate::units::{show_angle, show_length, show_quantity, three_digits};

/// The plans, best first.
pub fn settlement(found: &Diagnosis, plans: &[MeasurementPlan], title: &str) -> String {
    let title = heading(title);
    if plans.is_empty() {
        let word = found.verdict.word();
        return format!("{title}: the verdict is {word}; there is no tie to settle\n");
    }
    let mut text = format!(
        "{title}: measurements that would tell the rivals apart (separability; {TOLD_APART} is \
                            needed)\n\n"
    );
    let pairs: Vec<String> = plans[0].separations.iter().map(|s| format!("{} / {}", s.effect, s.rival)).collect();
    for (k, pair) in pairs.iter().enumerate() {
        text += &format!("  ({}) {pair}\n", k + 1);
    }
    text.push('\n');
    let numbers: Vec<String> = (1..=pairs.len()).map(|k| format!("({k})")).collect();
    let mut header = vec!["measure"];
    header.extend(numbers.iter().map(String::as_str));
    let rows: Vec<Vec<String>> = plans
        .iter()
        .map(|p| {
            let cells = p.separations.iter().map(|s| three_digits(s.separability));
            std::iter::once(p.what.clone()).chain(cells).collect()
        })
        .collect();
    text += &table(&header, &rows);
    let best = &plans[0];
    text += &match best.settles() {
        true => format!("\nMeasure {}: that separates every pair of rivals.\n", best.what),
        false => format!(
            "\nNone of these separates every pair; the best is {} (weakest pair {}).\n",
            best.what,
            three_digits(best.weakest())
        ),
    };
    text
}

/// Detection limits of a planned campaign, and its assumptions.
#[derive(Clone, Debug)]
pub struct CampaignLimits {
    /// Number of poses.
    pub poses: usize,
    /// 1σ of a measurement.
    pub noise: Noise,
    /// The conditions in words.
    pub conditions: String,
    /// Limits of the effects that it sees.
    pub limits: Vec<NotFound>,
    /// Effects that cannot be tested, with what they need.
    pub missing: Vec<NotTestable>,
}

/// Text output of the detection limits of a planned campaign, with its noise and its conditions.
pub fn campaign_limits(c: &CampaignLimits) -> String {
    let (position, rotation) = (show_length(c.noise.position), show_angle(c.noise.rotation));
    format!(
        "{} poses in this order, noise {position} and {rotation}\n{}\n{}",
        c.poses,
        c.conditions,
        detection_limits(&c.limits, &c.missing)
    )
}

/// Effects with the sizes that would be seen.
pub(super) fn limit_table(limits: &[NotFound]) -> String {
    let row = |n: &NotFound| vec![n.effect.clone(), n.parameter.clone(), show_quantity(n.limit, n.dimension)];
    table(&["effect", "parameter", "limit"], &limits.iter().map(row).collect::<Vec<_>>())
}

/// The limits of effects, and what others miss.
pub fn detection_limits(limits: &[NotFound], missing: &[NotTestable]) -> String {
    let mut text = format!("smallest size that is detected with 95 % probability:\n{}", limit_table(limits));
    if !missing.is_empty() {
        text += "\nnot testable with this campaign:\n";
        for n in missing {
            text += &format!("  {}: needs {}\n", n.effect, n.missing.join(", "));
        }
    }
    text
}
