//! The whole job: candidates, choice, bound, forecast.

use nalgebra::DMatrix;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;

use super::forecast::{Forecast, Forecaster};
use super::relaxation::relax_with;
use super::{Campaign, Candidates, Numbered, PoseSelector, Problem, SelectionError, Sources, Step};
use crate::observability::{DECIDED, Goal, ObservabilityIndex, PoseError, Spectrum};
use crate::pose::Pose;

/// The index to optimise.
#[derive(Clone, Copy, Debug)]
pub enum Objective<'a> {
    /// This one.
    Index(&'a dyn ObservabilityIndex),
    /// The predicted error at the targets of this forecaster.
    PoseError(&'a Forecaster<'a>),
}

/// A campaign to plan.
#[derive(Clone, Copy)]
pub struct SelectionTask<'a> {
    /// Mechanism, workspace and scaling.
    pub campaign: &'a Campaign<'a>,
    /// Predicts what the choice will be worth; `None` if noise or tolerances are not known.
    pub forecaster: Option<&'a Forecaster<'a>>,
    /// Objective of the selection.
    pub aim: Objective<'a>,
    /// Poses that are measured anyway.
    pub given: &'a [Pose],
    /// Random seed.
    pub seed: u64,
    /// Told of progress.
    pub watch: &'a (dyn Fn(Step) + Sync),
}

/// The chosen set, and how good it is.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ChosenSet {
    /// All poses: the given ones, then the chosen ones.
    pub poses: Vec<Pose>,
    /// Name of the index.
    pub index: String,
    /// Its value, through the singular values of the stacked rows.
    pub value: f64,
    /// No set of candidates, polished poses among them, is better; `None` where no bound is known.
    pub bound: Option<f64>,
    /// Value over bound, or bound over value where small is good; at most one.
    pub efficiency: Option<f64>,
    /// Iterations of the selector.
    pub iterations: usize,
    /// Value for the first set, then after each of them.
    pub trace: Vec<f64>,
    /// Number of candidates.
    pub candidates: usize,
    /// Directions of the parameters that no candidate sees; the index is taken over the others.
    pub invisible: usize,
    /// Predicted accuracy of a calibration with these poses.
    pub forecast: Option<Forecast>,
}

/// Stream of the generator that orders poses: apart from the one that chooses them.
const ORDER: u64 = 1;

impl ChosenSet {
    /// Puts the poses behind the `given` ones in random order. Measured as a search leaves them, sorted by a coordinate, a
    /// drift would look like that coordinate.
    pub fn shuffle(&mut self, given: usize, seed: u64) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(ORDER);
        if let Some(new) = self.poses.get_mut(given..) {
            new.shuffle(&mut rng);
        }
    }

    /// How many poses are in the set more than once.
    pub fn repeated(&self) -> usize {
        let is_first = |k: &usize| !self.poses[..*k].contains(&self.poses[*k]);
        let again = |k: &usize| self.poses[*k + 1..].contains(&self.poses[*k]);
        (0..self.poses.len()).filter(is_first).filter(again).count()
    }
}

/// Collects candidates and chooses `n` poses in all, given ones included.
///
/// # Errors
/// [`SelectionError`].
pub fn select(
    plan: &SelectionTask<'_>,
    selector: &dyn PoseSelector,
    sources: &Sources,
    n: usize,
) -> Result<ChosenSet, SelectionError> {
    let candidates = Candidates::collect(plan.campaign, sources)?;
    select_among(plan, selector, &candidates, n, true)
}

/// Selects poses among candidates that were collected before; the bound takes a tenth of a second or more.
///
/// # Errors
/// [`SelectionError`].
pub fn select_among(
    plan: &SelectionTask<'_>,
    selector: &dyn PoseSelector,
    candidates: &Candidates,
    n: usize,
    with_bound: bool,
) -> Result<ChosenSet, SelectionError> {
    if n <= plan.given.len() {
        return Err(SelectionError::NothingToSelect { wanted: n, given: plan.given.len() });
    }
    let visible = candidates.pool.visible();
    let given = given_rows(plan, visible)?;
    let error;
    let index = match plan.aim {
        Objective::Index(index) => index,
        Objective::PoseError(forecaster) => {
            error = pose_error(plan, forecaster, candidates, &given, n);
            &error
        }
    };
    let directions = visible.ncols();
    if 6 * n < directions && !index.prior() {
        return Err(SelectionError::TooFewPoses {
            poses: n,
            rows: 6 * n,
            directions,
            index: index.name().into(),
            least: directions.div_ceil(6),
        });
    }
    let problem = Problem {
        campaign: plan.campaign,
        candidates,
        index,
        given: &given,
        count: n - plan.given.len(),
        seed: plan.seed,
        watch: plan.watch,
    };
    let found = selector.select_numbered(&problem)?;
    let value = problem.value_of(&found.choice.poses);
    let bound = if with_bound { certify(&problem, &found) } else { None };
    let choice = found.choice;
    let efficiency = bound.map(|b| match index.goal() {
        Goal::Largest => value / b,
        Goal::Smallest => b / value,
    });
    let poses: Vec<Pose> = plan.given.iter().chain(&choice.poses).copied().collect();
    Ok(ChosenSet {
        index: index.name().into(),
        value,
        bound,
        efficiency,
        iterations: choice.iterations,
        trace: choice.trace,
        candidates: candidates.len(),
        invisible: visible.nrows() - directions,
        forecast: plan.forecaster.map(|f| f.forecast(&poses)),
        poses,
    })
}

fn given_rows(plan: &SelectionTask<'_>, visible: &DMatrix<f64>) -> Result<Vec<DMatrix<f64>>, SelectionError> {
    let rows = |(row, pose): (usize, &Pose)| {
        let block = plan.campaign.block(pose).map_err(|cause| SelectionError::Given { row, cause })?;
        let silent = || DMatrix::zeros(6, visible.nrows());
        Ok(block.rows().unwrap_or_else(silent) * visible)
    };
    plan.given.iter().enumerate().map(rows).collect()
}

/// The predicted error as index, with the tolerances as prior if good poses alone do not decide every direction.
fn pose_error(
    plan: &SelectionTask<'_>,
    forecaster: &Forecaster<'_>,
    candidates: &Candidates,
    given: &[DMatrix<f64>],
    n: usize,
) -> PoseError {
    let visible = candidates.pool.visible();
    let without = forecaster.index(visible, false);
    let count = (n - given.len()).min(candidates.len());
    let problem = Problem {
        campaign: plan.campaign,
        candidates,
        index: &without,
        given,
        count,
        seed: plan.seed,
        watch: plan.watch,
    };
    let set = problem.set(&problem.greedy());
    let values = Spectrum::of(&set.rows(), n, false).values;
    let prior = 6 * n < visible.ncols() || values.iter().any(|s| *s < DECIDED);
    without.with_prior(prior)
}

/// The bound over the candidates and those poses of a choice that are none of them.
fn certify(problem: &Problem<'_>, found: &Numbered) -> Option<f64> {
    let Numbered { choice, numbers } = found;
    let known = |k: usize, pose: &Pose| numbers.get(k).copied().flatten().or_else(|| problem.candidates.at(pose));
    let moved = choice.poses.iter().enumerate().filter(|(k, pose)| known(*k, pose).is_none());
    let blocks = moved.map(|(_, pose)| problem.campaign.block(pose).ok()).collect::<Option<Vec<_>>>()?;
    let pool = &problem.candidates.pool;
    // More poses of the same box see no other directions than the candidates do.
    let further = if blocks.is_empty() { None } else { Some(pool.alike(&blocks)?) };
    let (fixed, given) = (problem.fixed_rows(), problem.given.len());
    relax_with(pool, further.as_ref(), problem.index, &fixed, given, problem.count).map(|found| found.bound)
}
