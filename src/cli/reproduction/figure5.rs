//! Figure 5: how the integrated errors of Table 4 are distributed.

use super::conditions::{INDICES, Outcome, outcomes};
use super::exhibit::Listing;
use super::sets::Place;
use super::{Comparison, Exhibit, ReproduceError, ReproductionContext, Spread};
use crate::report::chart::{Axis, Figure, Panel, Series, Shape};
use crate::simulation::RunningStats;

/// Bars of a histogram.
const BARS: usize = 40;
/// Points of a density curve.
const POINTS: usize = 120;

pub(super) fn exhibit(context: &ReproductionContext<'_>) -> Result<Exhibit, ReproduceError> {
    let place = Place::of_section_4()?;
    let all = outcomes(context, &place)?;
    let comment = "Figure 5: integrated error (mm + degrees) of each calibration, with errors and noise of its own";
    let mut header = vec!["condition", "list", "draw"];
    header.extend(INDICES);
    let mut listing = Listing::new("figure5", comment, &header);
    let mut comparisons = Vec::new();
    for o in &all {
        for list in 0..o.draws[0].len() {
            for draw in 0..o.draws[0][list].len() {
                let numbers: Vec<f64> = (0..5).map(|k| o.draws[k][list][draw].unwrap_or(f64::NAN)).collect();
                listing.row(&[o.condition.name, &list.to_string(), &draw.to_string()], &numbers);
            }
        }
        comparisons.push(
            Comparison::ours(
                format!("{}: overlap of O1 with O5", o.condition.name),
                "",
                Spread::exactly(overlap(&pooled(o, 0), &pooled(o, 4))),
            )
            .because("share of the two histograms that is common: 1 is no difference"),
        );
    }
    let findings = vec![
        "The paper's histograms are narrow because all calibrations of a panel share one matrix of noise. With noise of its \
         own for each calibration the histograms of O1 and O5 cover each other for 15 poses and more."
            .into(),
    ];
    let title = "Distribution of the integrated error by index, under four conditions";
    let figure = figure(&all);
    Ok(Exhibit { name: "figure5", title, comparisons, findings, listings: vec![listing], figure, took: None })
}

fn pooled(o: &Outcome, index: usize) -> Vec<f64> {
    o.draws[index].iter().flatten().flatten().copied().collect()
}

/// Numbers in bars of this width from `low`, at the middle of each bar.
pub(super) fn histogram(values: &[f64], low: f64, width: f64, bars: usize) -> Vec<[f64; 2]> {
    let mut counts = vec![0.0; bars];
    for v in values {
        let bar = ((v - low) / width).floor();
        // The largest value belongs to the last bar.
        let bar = if *v >= low && bar == bars as f64 { bars - 1 } else { bar as usize };
        if *v >= low && bar < bars {
            counts[bar] += 1.0;
        }
    }
    counts.iter().enumerate().map(|(k, c)| [low + (k as f64 + 0.5) * width, *c]).collect()
}

/// The share that two sets of draws have in common, by histograms over both.
fn overlap(a: &[f64], b: &[f64]) -> f64 {
    let all = RunningStats::of(a.iter().chain(b).copied());
    let width = (all.largest() - all.least()) / BARS as f64;
    let (in_a, in_b) = (histogram(a, all.least(), width, BARS), histogram(b, all.least(), width, BARS));
    let share = |(x, y): (&[f64; 2], &[f64; 2])| (x[1] / a.len() as f64).min(y[1] / b.len() as f64);
    in_a.iter().zip(&in_b).map(share).sum()
}

/// Density of draws by normal kernels of Silverman's width (1986, eq. 3.28).
fn density(values: &[f64], low: f64, high: f64) -> Vec<[f64; 2]> {
    let sd = RunningStats::of(values.iter().copied()).sd();
    let width = 1.06 * sd * (values.len() as f64).powf(-0.2);
    let scale = 1.0 / (values.len() as f64 * width * (2.0 * std::f64::consts::PI).sqrt());
    let at = |k: usize| {
        let x = low + (high - low) * k as f64 / (POINTS - 1) as f64;
        let sum: f64 = values.iter().map(|v| (-0.5 * ((x - v) / width).powi(2)).exp()).sum();
        [x, scale * sum]
    };
    (0..POINTS).map(at).collect()
}

fn figure(all: &[Outcome]) -> Figure {
    let panel = |o: &Outcome| {
        let draws: Vec<Vec<f64>> = (0..5).map(|k| pooled(o, k)).collect();
        // Far outliers would leave the rest to a corner of the panel.
        let high = draws.iter().map(|d| super::comparison::quantile(d, 0.98)).fold(0.0, f64::max);
        let width = high / BARS as f64;
        let mut series = Vec::new();
        for (k, index) in INDICES.iter().enumerate() {
            let bars = histogram(&draws[k], 0.0, width, BARS);
            series.push(Series::new("", k, Shape::Bars { width }, bars));
            let curve = density(&draws[k], 0.0, high);
            series.push(Series { right: true, ..Series::new(index.to_uppercase(), k, Shape::Line, curve) });
        }
        Panel {
            title: format!("Condition {}: {} poses", o.condition.name, o.condition.poses),
            x: Axis { range: Some((0.0, high)), ..Axis::linear("integrated error (mm + deg), up to the largest 2 %") },
            y: Axis::linear("calibrations"),
            right: Some(Axis::linear("probability density")),
            series,
            ..Panel::default()
        }
    };
    Figure {
        title: "Figure 5: integrated error by index".into(),
        description:
            "Four panels, one a condition: histograms and densities of the integrated error for poses chosen by each \
                      of five indices; O2 and O4 lie to the right of O1 and O5."
                .into(),
        columns: 2,
        panels: all.iter().map(panel).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_one_bar_and_a_density_has_area_one() {
        let values: Vec<f64> = (0..1000).map(|k| (f64::from(k) * 0.618).fract() + 1.0).collect();
        let all = RunningStats::of(values.iter().copied());
        let bars = histogram(&values, all.least(), (all.largest() - all.least()) / 7.0, 7);
        assert_eq!(bars.iter().map(|b| b[1]).sum::<f64>(), 1000.0);
        let curve = density(&values, 0.0, 3.0);
        let area: f64 = curve.windows(2).map(|w| 0.5 * (w[0][1] + w[1][1]) * (w[1][0] - w[0][0])).sum();
        assert!((area - 1.0).abs() < 1e-3, "{area}");
        assert!((overlap(&values, &values) - 1.0).abs() < 1e-12);
        let shifted: Vec<f64> = values.iter().map(|v| v + 2.0).collect();
        assert_eq!(overlap(&values, &shifted), 0.0);
    }
}
