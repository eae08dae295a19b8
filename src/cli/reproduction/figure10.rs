//! Figure 10: integrated error against the number of poses, with chosen and with random poses.

use super::calibrations::{Draws, Fit, Study, Truth, calibrate};
use super::comparison::quantile;
use super::context::Purpose;
use super::exhibit::Listing;
use super::sets::{Chosen, How, Place, Wanted, choose};
use super::{Comparison, Exhibit, ReproduceError, ReproductionContext, Spread, paper, small_stroke};
use crate::report::chart::{Axis, Figure, Panel, Series, Shape};
use crate::simulation::RunningStats;

/// Numbers of poses.
const POSES: [usize; 12] = [8, 10, 12, 14, 16, 20, 25, 30, 40, 50, 60, 80];
/// Lists in which our own sets are chosen: corners make them nearly independent of the list.
const IMPROVED_LISTS: u64 = 1;

/// A curve of the figure.
struct Curve {
    name: &'static str,
    how: How,
    fit: Fit,
    /// By number of poses, then list: all draws.
    errors: Vec<Vec<Vec<f64>>>,
}

impl Curve {
    fn lists(&self, context: &ReproductionContext<'_>) -> u64 {
        match self.how {
            How::Improved => IMPROVED_LISTS,
            how => how.lists(context),
        }
    }

    /// Mean errors over draws for a number of poses, one for each list.
    fn means(&self, k: usize) -> Vec<f64> {
        self.errors[k].iter().map(|draws| RunningStats::of(draws.iter().copied()).mean()).collect()
    }

    /// The expected error: mean over lists, or the median of random sets, whose mean is that of a few very bad ones.
    fn expected(&self, k: usize) -> f64 {
        let means = self.means(k);
        if self.how == How::Random { quantile(&means, 0.5) } else { RunningStats::of(means).mean() }
    }

    /// 95 % confidence interval of the expected error.
    fn interval(&self, k: usize) -> (f64, f64) {
        let means = self.means(k);
        if self.how == How::Random {
            // Order statistics about the median: binomial, normal approximation.
            let half = 0.98 / (means.len() as f64).sqrt();
            return (quantile(&means, 0.5 - half), quantile(&means, 0.5 + half));
        }
        let spread = if means.len() > 1 { Spread::of_mean(&means) } else { Spread::exactly(means[0]) };
        let draws = RunningStats::of(self.errors[k].iter().flatten().copied());
        let half = 1.96 * draws.standard_error();
        (spread.low.min(spread.mean - half), spread.high.max(spread.mean + half))
    }

    fn at(&self, n: usize) -> f64 {
        self.expected(place_of(n))
    }

    /// The same with its confidence interval.
    fn expected_at(&self, n: usize) -> Spread {
        let (low, high) = self.interval(place_of(n));
        Spread { mean: self.at(n), error: 0.0, low, high }
    }

    /// In the legend: what "expected" means.
    fn legend(&self) -> String {
        if self.how == How::Random { format!("{} (median of sets)", self.name) } else { self.name.into() }
    }
}

fn curves(context: &ReproductionContext<'_>, place: &Place) -> Result<[Curve; 5], ReproduceError> {
    let targets = place.random(context.seed(Purpose::Targets, 1), paper::TARGETS.1);
    let curve = |name, how, fit| Curve { name, how, fit, errors: Vec::new() };
    let mut curves = [
        curve("O1", How::Tabu("o1"), Fit::Paper),
        curve("random", How::Random, Fit::Paper),
        curve("O1, weighted rows", How::Tabu("o1"), Fit::Weighted),
        curve("random, weighted rows", How::Random, Fit::Weighted),
        curve("improved poses, weighted rows", How::Improved, Fit::Weighted),
    ];
    let wanted_by = |c: &Curve| -> Vec<Wanted> {
        POSES.iter().flat_map(|n| Wanted::over(context, c.how, *n, c.lists(context))).collect()
    };
    let mut studies = Vec::new();
    for c in &curves {
        let wanted = wanted_by(c);
        let sets: Vec<Chosen> = choose(context, place, "figure 10", &wanted)?;
        for (w, set) in wanted.iter().zip(&sets) {
            studies.push(Study {
                place,
                set: format!("{:?} {}, list {}", w.how, w.n, w.list),
                poses: set.poses(),
                targets: &targets,
                at: "150 targets of figure 10".into(),
                noise: paper::noise(),
                truth: Truth::Table6,
                fit: c.fit,
                draws: (context.settings.draws / c.lists(context)).max(5),
                seed: context.seed(Purpose::Draws, 0x10_0000 | w.list),
            });
        }
    }
    let mut results =
        calibrate(context, "figure 10", &studies)?.iter().map(Draws::integrated).collect::<Vec<_>>().into_iter();
    for c in &mut curves {
        let lists = c.lists(context) as usize;
        c.errors = POSES.iter().map(|_| results.by_ref().take(lists).collect()).collect();
    }
    Ok(curves)
}

pub(super) fn exhibit(context: &ReproductionContext<'_>) -> Result<Exhibit, ReproduceError> {
    let place = Place::of_section_5()?;
    let curves = curves(context, &place)?;
    let small = small_stroke::compare(context)?;
    let comment = "Figure 10: expected integrated error (mm + degrees) by number of poses, with its 95 % confidence interval; the \
                   median of sets for random poses";
    let mut listing = Listing::new("figure10", comment, &["poses", "calibration", "error", "low", "high"]);
    for (k, n) in POSES.iter().enumerate() {
        for c in &curves {
            let (low, high) = c.interval(k);
            listing.row(&[&n.to_string(), c.name], &[c.expected(k), low, high]);
        }
    }
    let [chosen, random, weighted, weighted_random, improved] = &curves;
    let worth = quotient(chosen.expected_at(20), random.expected_at(50));
    let falls = Spread::of_mean(&quotients(&chosen.means(place_of(50)), &chosen.means(place_of(20))));
    let mut comparisons = vec![
        Comparison::claim(
            "error of 20 poses with O1 (mean) over that of 50 random poses (median of sets)",
            "approximately equal to the accuracy of traditional calibration methods using 50 measurement poses",
            worth,
            (worth.low..=worth.high).contains(&1.0),
        ),
        Comparison::claim(
            "error with O1 for 50 poses over that for 20, list by list",
            "there is no significant change in the integrated error by increasing the number of measurement poses",
            falls,
            falls.high > 0.9,
        )
        .because("one noise draw for each number of poses hides a fall of this size"),
    ];
    for (c, n) in [(chosen, 20), (random, 20), (random, 50), (weighted, 20), (improved, 20)] {
        comparisons.push(Comparison::ours(format!("{n} poses: {}", c.name), "mm + deg", c.expected_at(n)));
    }
    let mut findings = vec![bump(chosen, random, weighted_random), equal_poses(context, &place)?];
    let equal: Vec<String> = POSES
        .iter()
        .filter_map(|n| equivalent(chosen.at(*n), random).map(|m| format!("{n} chosen are worth {m:.0} random")))
        .collect();
    findings.push(format!("Chosen poses and the number of random poses with the same error: {}.", equal.join(", ")));
    findings.push(format!(
        "The improved procedure at 20 poses has {:.2} of the error of the paper's.",
        improved.at(20) / chosen.at(20)
    ));
    findings.extend(small.findings());
    let figure = figure(&curves);
    Ok(Exhibit {
        name: "figure10",
        title: "Integrated error against the number of measured poses",
        comparisons,
        findings,
        listings: vec![listing, small.listing()],
        figure,
        took: None,
    })
}

/// The place of a number of poses in [`POSES`].
fn place_of(n: usize) -> usize {
    POSES.iter().position(|p| *p >= n).unwrap_or(POSES.len() - 1)
}

fn quotients(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a / b).collect()
}

/// The quotient of two independent estimates, with both intervals.
fn quotient(a: Spread, b: Spread) -> Spread {
    let mean = a.mean / b.mean;
    let part = |a: f64, b: f64| a.hypot(b) * mean;
    let (below, above) = ((a.mean - a.low) / a.mean, (a.high - a.mean) / a.mean);
    let (under, over) = ((b.mean - b.low) / b.mean, (b.high - b.mean) / b.mean);
    Spread { mean, error: 0.0, low: mean - part(below, over), high: mean + part(above, under) }
}

/// The number of random poses whose error is this, between the numbers of the figure; `None` beyond them.
fn equivalent(error: f64, random: &Curve) -> Option<f64> {
    let errors: Vec<f64> = (0..POSES.len()).map(|k| random.expected(k)).collect();
    // From the end, where the error falls steadily: it rises between 10 and 12 poses.
    (1..POSES.len()).rev().find(|k| errors[*k] <= error && error <= errors[k - 1]).map(|k| {
        let share = (errors[k - 1] / error).ln() / (errors[k - 1] / errors[k]).ln();
        (POSES[k - 1] as f64 * (POSES[k] as f64 / POSES[k - 1] as f64).powf(share)).round()
    })
}

fn bump(chosen: &Curve, random: &Curve, weighted: &Curve) -> String {
    let value = |c: &Curve, n: usize| format!("{:.4}", c.at(n));
    let all = |c: &Curve| [8, 10, 12, 14, 16].map(|n| value(c, n)).join(", ");
    format!(
        "For 8, 10, 12, 14, 16 poses the unweighted estimator has {} if they are random and {} with O1; for random poses the weighted \
         one has {}. With 3n < 42 position rows the weak angle rows have to carry parameters, and more poses can be worse if they \
         are not weighted.",
        all(random),
        all(chosen),
        all(weighted)
    )
}

/// How many of the 20 poses the two scalings share among the same candidates.
fn equal_poses(context: &ReproductionContext<'_>, place: &Place) -> Result<String, ReproduceError> {
    let sets = |how: How| {
        choose(context, place, "both scalings", &Wanted::over(context, how, paper::POSES, context.settings.lists))
    };
    let (plain, whitened) = (sets(How::Tabu("o1"))?, sets(How::WhitenedTabu)?);
    let shared = RunningStats::of(plain.iter().zip(&whitened).map(|(a, b)| a.shared_with(b) as f64));
    Ok(format!(
        "Of the 20 poses that tabu DETMAX chooses for O1 in mm and rad, {:.1} ({:.0} to {:.0} over lists) are also chosen on \
         whitened rows: the choice depends little on the weighting, the estimate depends on it a lot.",
        shared.mean(),
        shared.least(),
        shared.largest()
    ))
}

fn figure(curves: &[Curve]) -> Figure {
    let mut series = Vec::new();
    for (colour, c) in curves.iter().enumerate() {
        let points: Vec<[f64; 2]> = POSES.iter().enumerate().map(|(k, n)| [*n as f64, c.expected(k)]).collect();
        let (lower, upper): (Vec<f64>, Vec<f64>) = (0..POSES.len()).map(|k| c.interval(k)).unzip();
        let band = POSES.iter().zip(upper).map(|(n, u)| [*n as f64, u]).collect();
        series.push(Series::new("", colour, Shape::Band { lower }, band));
        series.push(Series::new(c.legend(), colour, Shape::LineWithDots, points));
    }
    let panel = Panel {
        x: Axis::log("number of measured poses"),
        y: Axis::log("expected integrated error (mm + deg)"),
        series,
        ..Panel::default()
    };
    Figure {
        title: "Figure 10: error against the number of poses".into(),
        description:
            "Five falling curves over the number of poses: random poses highest, with a bump at 12 to 14; O1 lower; \
                      weighted rows lower still."
                .into(),
        columns: 1,
        panels: vec![panel],
    }
}
