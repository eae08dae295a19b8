//! Calibrations under the four conditions of Table 3, from which Table 4 and Figure 5 are made.

use super::calibrations::{Fit, Study, Truth, calibrate};
use super::context::Purpose;
use super::paper::{CONDITIONS, Condition};
use super::sets::{Chosen, How, Place, Wanted, choose};
use super::{ReproduceError, ReproductionContext, Spread, paper};
use crate::pose::Pose;
use crate::simulation::RunningStats;

/// The five indices, as the paper orders them.
pub(super) const INDICES: [&str; 5] = ["o1", "o2", "o3", "o4", "o5"];
/// Draws of the noise with each random set.
const DRAWS_A_RANDOM_SET: u64 = 20;

/// Integrated errors (mm + degrees) under a condition, by index, list of candidates and draw.
pub(super) struct Outcome {
    pub(super) condition: &'static Condition,
    /// The paper's estimator: index, list, draw. Draws of the same number share errors and noise.
    pub(super) draws: Vec<Vec<Vec<Option<f64>>>>,
    /// Weighted least squares with the same poses.
    pub(super) weighted: Vec<Vec<Vec<Option<f64>>>>,
    /// Our poses and weighted least squares: list, draw.
    pub(super) improved: Vec<Vec<Option<f64>>>,
    /// Random poses and the paper's estimator: set, draw.
    pub(super) random: Vec<Vec<Option<f64>>>,
}

/// Means over draws, one a list.
pub(super) fn means(lists: &[Vec<Option<f64>>]) -> Vec<f64> {
    lists.iter().map(|draws| RunningStats::of(draws.iter().flatten().copied()).mean()).collect()
}

/// All draws of all lists; the error of their mean is that over the lists.
pub(super) fn pooled(lists: &[Vec<Option<f64>>]) -> Spread {
    let succeeded = |draws: &Vec<Option<f64>>| draws.iter().flatten().copied().collect();
    Spread::of_sets(&lists.iter().map(succeeded).collect::<Vec<Vec<f64>>>())
}

/// What is calibrated under each condition.
pub(super) struct Bench<'a> {
    context: &'a ReproductionContext<'a>,
    place: &'a Place,
    targets: Vec<Vec<Pose>>,
}

impl<'a> Bench<'a> {
    pub(super) fn new(context: &'a ReproductionContext<'a>, place: &'a Place) -> Self {
        let targets = (0..context.settings.lists)
            .map(|list| place.random(context.seed(Purpose::Targets, list), paper::TARGETS.0));
        Self { context, place, targets: targets.collect() }
    }

    pub(super) fn study(
        &'a self,
        number: usize,
        list: u64,
        set: String,
        chosen: &Chosen,
        fit: Fit,
        draws: u64,
    ) -> Study<'a> {
        let which = list % self.context.settings.lists;
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
            seed: self.context.seed(Purpose::Draws, ((number as u64) << 16) | list),
        }
    }

    pub(super) fn wanted(&self, number: usize, how: How, lists: u64) -> Vec<Wanted> {
        Wanted::over(self.context, how, CONDITIONS[number].poses, lists)
    }
}

/// The sets of a condition and how they are calibrated, in the order in which [`outcomes`] takes the results.
fn plan() -> Vec<(How, Fit)> {
    let mut plan: Vec<(How, Fit)> = INDICES.iter().map(|i| (How::Tabu(i), Fit::Paper)).collect();
    plan.extend(INDICES.iter().map(|i| (How::Tabu(i), Fit::Weighted)));
    plan.extend([(How::Improved, Fit::Weighted), (How::Random, Fit::Paper)]);
    plan
}

/// All calibrations behind Table 4 and Figure 5.
pub(super) fn outcomes(context: &ReproductionContext<'_>, place: &Place) -> Result<Vec<Outcome>, ReproduceError> {
    let bench = Bench::new(context, place);
    let mut wanted = Vec::new();
    for number in 0..CONDITIONS.len() {
        for (how, _) in plan() {
            wanted.extend(bench.wanted(number, how, how.lists(context)));
        }
    }
    let mut chosen = choose(context, place, "table 4", &wanted)?.into_iter();
    let mut studies = Vec::new();
    for (number, condition) in CONDITIONS.iter().enumerate() {
        for (how, fit) in plan() {
            for list in 0..how.lists(context) {
                let Some(set) = chosen.next() else { continue };
                let name = format!("{how:?} {}, list {list}", condition.name);
                let draws = if how == How::Random { DRAWS_A_RANDOM_SET } else { context.settings.draws };
                studies.push(bench.study(number, list, name, &set, fit, draws));
            }
        }
    }
    let mut results = calibrate(context, "table 4", &studies)?.into_iter();
    let mut take = |count: u64| -> Vec<Vec<Option<f64>>> {
        results.by_ref().take(count as usize).map(|draws| draws.by_number()).collect()
    };
    let lists = context.settings.lists;
    let outcome = |condition: &'static Condition| Outcome {
        condition,
        draws: INDICES.iter().map(|_| take(lists)).collect(),
        weighted: INDICES.iter().map(|_| take(lists)).collect(),
        improved: take(lists),
        random: take(context.random_sets()),
    };
    Ok(CONDITIONS.iter().map(outcome).collect())
}
