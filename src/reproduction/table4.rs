//! Table 4: which index makes the calibration most accurate, under four measurement conditions.

use std::time::Instant;

use super::calibrations::{Draws, Fit, Study, Truth, calibrate};
use super::comparison::quantile;
use super::exhibit::Listing;
use super::lab::Purpose;
use super::paper::{CONDITIONS, Condition};
use super::sets::{Chosen, How, Place, Wanted, choose};
use super::{Comparison, Exhibit, Lab, ReproduceError, Spread, paper};
use crate::pose::Pose;
use crate::report::chart::{Axis, Figure, Panel, Series, Shape};
use crate::simulation::Running;

/// The five indices, as the paper orders them.
pub(super) const INDICES: [&str; 5] = ["o1", "o2", "o3", "o4", "o5"];
/// Half-ranges of a smaller workspace, mm and degrees.
const SMALLER: (f64, f64) = (20.0, 10.0);
/// Draws of the noise with each random set.
const DRAWS_A_RANDOM_SET: u64 = 20;
/// Parameter errors under one matrix of noise, as in section 4.3.
const PARAMETER_SETS: u64 = 100;
/// Matrices of noise for which that is repeated.
const NOISE_MATRICES: u64 = 3;

/// Integrated errors (mm + degrees) under a condition, by index, list of candidates and draw.
pub(super) struct Outcome {
    pub(super) condition: &'static Condition,
    /// The paper's estimator: index, list, draw. Draws of the same number share errors and noise.
    pub(super) draws: Vec<Vec<Vec<Option<f64>>>>,
    /// Weighted least squares with the same poses.
    weighted: Vec<Vec<Vec<Option<f64>>>>,
    /// Our poses and weighted least squares: list, draw.
    improved: Vec<Vec<Option<f64>>>,
    /// Random poses and the paper's estimator: set, draw.
    random: Vec<Vec<Option<f64>>>,
}

/// Means over draws, one a list.
fn means(lists: &[Vec<Option<f64>>]) -> Vec<f64> {
    lists.iter().map(|draws| Running::of(draws.iter().flatten().copied()).mean()).collect()
}

/// All draws of all lists; the error of their mean is that over the lists.
fn pooled(lists: &[Vec<Option<f64>>]) -> Spread {
    let succeeded = |draws: &Vec<Option<f64>>| draws.iter().flatten().copied().collect();
    Spread::of_sets(&lists.iter().map(succeeded).collect::<Vec<Vec<f64>>>())
}

/// What is calibrated under each condition.
struct Bench<'a> {
    lab: &'a Lab<'a>,
    place: &'a Place,
    targets: Vec<Vec<Pose>>,
}

impl<'a> Bench<'a> {
    fn new(lab: &'a Lab<'a>, place: &'a Place) -> Self {
        let targets =
            (0..lab.settings.lists).map(|list| place.random(lab.seed(Purpose::Targets, list), paper::TARGETS.0));
        Self { lab, place, targets: targets.collect() }
    }

    fn study(&'a self, number: usize, list: u64, set: String, chosen: &Chosen, fit: Fit, draws: u64) -> Study<'a> {
        let which = list % self.lab.settings.lists;
        Study {
            place: self.place,
            set,
            poses: chosen.poses(),
            targets: &self.targets[which as usize],
            at: format!("30 targets of list {which}"),
            noise: CONDITIONS[number].noise(),
            truth: Truth::Drawn,
            fit,
            draws,
            seed: self.lab.seed(Purpose::Draws, ((number as u64) << 16) | list),
        }
    }

    fn wanted(&self, number: usize, how: How, lists: u64) -> Vec<Wanted> {
        let (n, candidates) = (CONDITIONS[number].poses, self.lab.settings.candidates);
        (0..lists).map(|list| Wanted { how, n, list, candidates }).collect()
    }
}

/// The sets of a condition and how they are calibrated, in the order in which [`outcomes`] takes the results.
fn plan() -> Vec<(How, Fit)> {
    let mut plan: Vec<(How, Fit)> = INDICES.iter().map(|i| (How::Tabu(i), Fit::Paper)).collect();
    plan.extend(INDICES.iter().map(|i| (How::Tabu(i), Fit::Weighted)));
    plan.extend([(How::Improved, Fit::Weighted), (How::Random, Fit::Paper)]);
    plan
}

fn lists_of(lab: &Lab<'_>, how: How) -> u64 {
    if how == How::Random { lab.random_sets() } else { lab.settings.lists }
}

/// All calibrations behind Table 4 and Figure 5.
pub(super) fn outcomes(lab: &Lab<'_>, place: &Place) -> Result<Vec<Outcome>, ReproduceError> {
    let bench = Bench::new(lab, place);
    let mut wanted = Vec::new();
    for number in 0..CONDITIONS.len() {
        for (how, _) in plan() {
            wanted.extend(bench.wanted(number, how, lists_of(lab, how)));
        }
    }
    let mut chosen = choose(lab, place, "table 4", &wanted)?.into_iter();
    let mut studies = Vec::new();
    for (number, condition) in CONDITIONS.iter().enumerate() {
        for (how, fit) in plan() {
            for list in 0..lists_of(lab, how) {
                let Some(set) = chosen.next() else { continue };
                let name = format!("{how:?} {}, list {list}", condition.name);
                let draws = if how == How::Random { DRAWS_A_RANDOM_SET } else { lab.settings.draws };
                studies.push(bench.study(number, list, name, &set, fit, draws));
            }
        }
    }
    let mut results = calibrate(lab, "table 4", &studies)?.into_iter();
    let mut take = |count: u64| -> Vec<Vec<Option<f64>>> {
        let integrated = |d: Draws| d.draws.iter().map(|d| d.map(|d| d.integrated)).collect();
        results.by_ref().take(count as usize).map(integrated).collect()
    };
    let lists = lab.settings.lists;
    let outcome = |condition: &'static Condition| Outcome {
        condition,
        draws: INDICES.iter().map(|_| take(lists)).collect(),
        weighted: INDICES.iter().map(|_| take(lists)).collect(),
        improved: take(lists),
        random: take(lab.random_sets()),
    };
    Ok(CONDITIONS.iter().map(outcome).collect())
}

pub(super) fn exhibit(lab: &Lab<'_>) -> Result<Exhibit, ReproduceError> {
    let place = Place::of_section_4()?;
    let all = outcomes(lab, &place)?;
    let mut comparisons = Vec::new();
    let mut table = Listing::new(
        "table4",
        "Table 4: mean integrated error, mm + degrees; standard error over lists of candidates; central 95 % and \
         standard deviation of single noise draws; where the paper lies among them",
        &[
            "condition",
            "poses",
            "index",
            "paper",
            "ours",
            "standard_error",
            "low",
            "high",
            "sd",
            "percentile",
            "weighted",
            "weighted_error",
        ],
    );
    for o in &all {
        let condition = o.condition;
        for (k, index) in INDICES.iter().enumerate() {
            let (ours, weighted) = (pooled(&o.draws[k]), pooled(&o.weighted[k]));
            let draws: Vec<f64> = o.draws[k].iter().flatten().flatten().copied().collect();
            let printed = condition.integrated[k];
            let below = draws.iter().filter(|d| **d < printed).count() as f64 / draws.len().max(1) as f64;
            let sd = Running::of(draws.iter().copied()).sd();
            let numbers =
                [printed, ours.mean, ours.error, ours.low, ours.high, sd, 100.0 * below, weighted.mean, weighted.error];
            table.row(&[condition.name, &condition.poses.to_string(), index], &numbers);
            let quantity = format!("{} {}, {} poses", condition.name, index.to_uppercase(), condition.poses);
            comparisons
                .push(Comparison::new(quantity, "mm + deg", printed, ours).unless_reproduced(if printed > ours.mean {
                "larger than our draws: the workspace of section 4 is not stated, and a smaller one gives larger errors"
            } else {
                "smaller than our draws"
            }));
        }
        for (name, lists) in [("improved", &o.improved), ("random", &o.random)] {
            let ours = pooled(lists);
            let sd = Running::of(lists.iter().flatten().flatten().copied()).sd();
            let nothing = f64::NAN;
            let numbers = [nothing, ours.mean, ours.error, ours.low, ours.high, sd, nothing, nothing, nothing];
            table.row(&[condition.name, &condition.poses.to_string(), name], &numbers);
        }
    }
    comparisons.extend(smaller_workspace(lab)?);
    let ranking = Ranking::of(&all);
    comparisons.push(ranking.comparison());
    let (as_printed, took) = paper_once(lab, &place)?;
    let mut findings = ranking.findings();
    findings.push(improvement(&all));
    findings.push(as_printed.finding(&all));
    let figure = figure(&all);
    let listings = vec![table, ranking.listing, as_printed.listing];
    let title = "Mean integrated error of calibrations with poses chosen by five indices";
    Ok(Exhibit { name: "table4", title, comparisons, findings, listings, figure, took: Some(took) })
}

/// O1 in a smaller workspace, which fits Table 4 better.
fn smaller_workspace(lab: &Lab<'_>) -> Result<Vec<Comparison>, ReproduceError> {
    let place = Place::new("Table 2", paper::table_2()?, SMALLER);
    let bench = Bench::new(lab, &place);
    let how = How::Tabu("o1");
    let mut studies = Vec::new();
    for (number, condition) in CONDITIONS.iter().enumerate() {
        let chosen = choose(lab, &place, "table 4", &bench.wanted(number, how, lab.settings.lists))?;
        for (list, set) in (0..).zip(&chosen) {
            let name = format!("{how:?} {}, list {list}", condition.name);
            studies.push(bench.study(number, list, name, set, Fit::Paper, lab.settings.draws));
        }
    }
    let draws = calibrate(lab, "table 4", &studies)?;
    let of_condition = |(condition, draws): (&Condition, &[Draws])| {
        let lists: Vec<Vec<Option<f64>>> =
            draws.iter().map(|d| d.draws.iter().map(|d| d.map(|d| d.integrated)).collect()).collect();
        let quantity =
            format!("{} O1, {} poses, within {} mm and {} deg", condition.name, condition.poses, SMALLER.0, SMALLER.1);
        Comparison::new(quantity, "mm + deg", condition.integrated[0], pooled(&lists))
            .not_judged()
            .because("another workspace that section 4 may have had")
    };
    Ok(CONDITIONS.iter().zip(draws.chunks(lab.settings.lists as usize)).map(of_condition).collect())
}

/// Which index is best, and how sure that is.
struct Ranking {
    /// Probability that O1 wins all four conditions on single draws, one a list.
    all_four: Vec<f64>,
    /// For each condition: ratios O5 over O1 by list, with the paper's estimator and weighted.
    ratios: Vec<[Vec<f64>; 2]>,
    listing: Listing,
}

impl Ranking {
    fn of(all: &[Outcome]) -> Self {
        let comment = "share of noise draws in which an index gives the smallest error; mean error over that of O1 with its \
                       95 % interval over lists, with the paper's estimator and with weighted rows";
        let header = [
            "condition",
            "index",
            "wins",
            "over_o1",
            "low",
            "high",
            "weighted_over_o1",
            "weighted_low",
            "weighted_high",
        ];
        let mut listing = Listing::new("table4-ranking", comment, &header);
        let lists = all[0].draws[0].len();
        let mut all_four = vec![1.0; lists];
        let mut ratios = Vec::new();
        for o in all {
            let wins: Vec<[f64; 5]> = (0..lists).map(|list| wins(o, list)).collect();
            for (p, w) in all_four.iter_mut().zip(&wins) {
                *p *= w[0];
            }
            let over = |cells: &[Vec<Vec<Option<f64>>>], k: usize| -> Vec<f64> {
                means(&cells[k]).iter().zip(means(&cells[0])).map(|(a, b)| a / b).collect()
            };
            for (k, index) in INDICES.iter().enumerate() {
                let won = wins.iter().map(|w| w[k]).sum::<f64>() / lists as f64;
                let (plain, weighted) = (Spread::of_mean(&over(&o.draws, k)), Spread::of_mean(&over(&o.weighted, k)));
                let numbers = [won, plain.mean, plain.low, plain.high, weighted.mean, weighted.low, weighted.high];
                listing.row(&[o.condition.name, index], &numbers);
            }
            ratios.push([over(&o.draws, 4), over(&o.weighted, 4)]);
        }
        Self { all_four, ratios, listing }
    }

    fn comparison(&self) -> Comparison {
        let Spread { mean, error, low, high } = Spread::of_mean(&self.all_four);
        let probability = Spread { mean, error, low: low.max(0.0), high: high.min(1.0) };
        let claim = "the calibration based on O1 has the highest accuracy";
        Comparison::claim(
            "probability that O1 wins all four on single draws",
            claim,
            probability,
            probability.low > 0.5,
        )
        .because("the paper found it in one draw and took it for the rule")
    }

    fn findings(&self) -> Vec<String> {
        let describe = |which: usize| -> String {
            let one = |(o, r): (&Condition, &[Vec<f64>; 2])| {
                let s = Spread::of_mean(&r[which]);
                let better = match () {
                    () if s.low > 1.0 => "O1 is better",
                    () if s.high < 1.0 => "O5 is better",
                    () => "not decided",
                };
                format!("{} {:.3} ({:.3} to {:.3}: {better})", o.name, s.mean, s.low, s.high)
            };
            CONDITIONS.iter().zip(&self.ratios).map(one).collect::<Vec<_>>().join(", ")
        };
        vec![
            format!("Mean error with O5 over that with O1, the paper's estimator: {}.", describe(0)),
            format!("The same with weighted rows: {}.", describe(1)),
        ]
    }
}

/// Share of draws that each index wins, for one list.
fn wins(o: &Outcome, list: usize) -> [f64; 5] {
    let mut won = [0.0; 5];
    let mut counted = 0.0_f64;
    for draw in 0..o.draws[0][list].len() {
        let errors: Option<Vec<f64>> = (0..5).map(|k| o.draws[k][list][draw]).collect();
        let Some(errors) = errors else { continue };
        counted += 1.0;
        if let Some(best) = (0..5).min_by(|a, b| errors[*a].total_cmp(&errors[*b])) {
            won[best] += 1.0;
        }
    }
    won.map(|w| w / counted.max(1.0))
}

fn improvement(all: &[Outcome]) -> String {
    let one = |o: &Outcome| {
        let ratio = pooled(&o.improved).mean / pooled(&o.draws[0]).mean;
        format!("{} {ratio:.2}", o.condition.name)
    };
    format!(
        "Weighted rows and poses chosen on weighted rows with corners (exchange), over the paper's O1 procedure: {}.",
        all.iter().map(one).collect::<Vec<_>>().join(", ")
    )
}

/// The paper's own experiment: one matrix of noise a condition, a hundred sets of parameter errors under it.
struct AsPrinted {
    listing: Listing,
    /// Largest spread over the parameter errors, relative to the mean.
    within: f64,
}

fn paper_once(lab: &Lab<'_>, place: &Place) -> Result<(AsPrinted, String), ReproduceError> {
    let bench = Bench::new(lab, place);
    let mut studies = Vec::new();
    for number in 0..CONDITIONS.len() {
        for index in INDICES {
            let chosen = choose(lab, place, "table 4", &bench.wanted(number, How::Tabu(index), 1))?;
            for matrix in 0..NOISE_MATRICES {
                let study = bench.study(number, 0, String::new(), &chosen[0], Fit::Paper, PARAMETER_SETS);
                studies.push((number, index, matrix, Study { truth: Truth::UnderOneNoise(matrix), ..study }));
            }
        }
    }
    let comment = "the paper's experiment: mean and standard deviation of the integrated error (mm + degrees) over 100 sets of \
                   parameter errors under one matrix of noise, for three matrices";
    let mut listing =
        Listing::new("table4-one-noise-draw", comment, &["condition", "index", "noise_matrix", "mean", "sd"]);
    let mut within = 0.0_f64;
    let (mut seconds, mut calibrations) = (0.0, 0);
    for (number, index, matrix, study) in &studies {
        let start = Instant::now();
        let draws = study.run()?;
        if *matrix == 0 {
            seconds += start.elapsed().as_secs_f64();
            calibrations += draws.draws.len();
        }
        let all = Running::of(draws.integrated());
        within = within.max(all.sd() / all.mean());
        listing.row(&[CONDITIONS[*number].name, index, &matrix.to_string()], &[all.mean(), all.sd()]);
    }
    let took = format!(
        "the paper's {calibrations} calibrations, full and nonlinear, took {seconds:.2} s on {} threads",
        rayon::current_num_threads()
    );
    Ok((AsPrinted { listing, within }, took))
}

impl AsPrinted {
    fn finding(&self, all: &[Outcome]) -> String {
        let relative = |o: &Outcome| -> Vec<f64> {
            let of_cell = |lists: &Vec<Vec<Option<f64>>>| {
                let all = Running::of(lists.iter().flatten().flatten().copied());
                all.sd() / all.mean()
            };
            o.draws.iter().map(of_cell).collect()
        };
        let spreads: Vec<f64> = all.iter().flat_map(relative).collect();
        format!(
            "A hundred sets of parameter errors under one matrix of noise average nothing: their spread is at most {:.1} % of \
             the mean, that of noise draws {:.0} to {:.0} %. The paper's 2000 calibrations are four independent comparisons.",
            100.0 * self.within,
            100.0 * quantile(&spreads, 0.0),
            100.0 * quantile(&spreads, 1.0)
        )
    }
}

fn figure(all: &[Outcome]) -> Figure {
    let names: Vec<String> = INDICES.iter().map(|i| i.to_uppercase()).collect();
    let panel = |o: &Outcome| {
        let spreads: Vec<Spread> = o.draws.iter().map(|lists| pooled(lists)).collect();
        let at = |k: usize, by: f64, v: f64| [k as f64 + by, v];
        let ours = spreads.iter().enumerate().map(|(k, s)| at(k, -0.15, s.mean)).collect();
        let ends = spreads.iter().map(|s| [s.low, s.high]).collect();
        let weighted = o.weighted.iter().enumerate().map(|(k, lists)| at(k, 0.0, pooled(lists).mean)).collect();
        let printed = o.condition.integrated.iter().enumerate().map(|(k, v)| at(k, 0.15, *v)).collect();
        Panel {
            title: format!("{}: {} poses, {} mm", o.condition.name, o.condition.poses, o.condition.position_mm),
            x: Axis::named("index", names.clone()),
            y: Axis::linear("integrated error (mm + deg)"),
            series: vec![
                Series::new("ours, 95 % of draws", 0, Shape::ErrorBars { ends }, ours),
                Series::new("paper, one draw", 1, Shape::Dots, printed),
                Series::new("ours, weighted rows", 2, Shape::Dots, weighted),
            ],
            ..Panel::default()
        }
    };
    Figure {
        title: "Table 4: integrated error by index".into(),
        description:
            "Four panels, one a condition: mean error of calibrations with poses chosen by each index, the spread of \
                      single noise draws, and the paper's single draw."
                .into(),
        columns: 2,
        panels: all.iter().map(panel).collect(),
    }
}
