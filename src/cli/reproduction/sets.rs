//! Sets of poses, chosen in the paper's way and in ours.

use rand::seq::index::sample;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::context::Purpose;
use super::{ReproduceError, ReproductionContext, paper};
use crate::files::Machine;
use crate::mechanism::{Mechanism, Workspace};
use crate::observability::{O1, ObservabilityIndex, PoseSet, Scaling, index};
use crate::pose::Pose;
use crate::selection::{Campaign, Candidates, Choice, Detmax, Exchange, PoseSelector, Problem, Sources, TabuDetmax};
use crate::simulation::stream;

/// A mechanism of the paper in a workspace.
pub(super) struct Place {
    /// In keys and in texts.
    pub(super) name: String,
    machine: Machine,
    pub(super) space: Workspace,
}

impl Place {
    /// The mechanism of section 5 in the workspace of the paper.
    pub(super) fn of_section_5() -> Result<Self, ReproduceError> {
        Ok(Self::new("Table 5", paper::table_5()?, paper::WORKSPACE))
    }

    /// The mechanism of section 4 in the same workspace.
    pub(super) fn of_section_4() -> Result<Self, ReproduceError> {
        Ok(Self::new("Table 2", paper::table_2()?, paper::WORKSPACE))
    }

    /// A mechanism in a box of ± mm and ± degrees about home.
    pub(super) fn new(name: &str, machine: Machine, half: (f64, f64)) -> Self {
        let space = paper::workspace(machine.mechanism.as_ref(), half);
        Self { name: format!("{name} within {} mm and {} deg", half.0, half.1), machine, space }
    }

    pub(super) fn nominal(&self) -> &dyn Mechanism {
        self.machine.mechanism.as_ref()
    }

    fn campaign(&self, scaling: Scaling) -> Result<Campaign<'_>, ReproduceError> {
        Ok(Campaign::new(self.nominal(), &self.space, self.machine.noise.as_ref(), scaling)?)
    }

    /// Poses drawn uniformly from the workspace.
    pub(super) fn random(&self, seed: u64, count: usize) -> Vec<Pose> {
        let mut rng = stream(seed, 0);
        (0..count).map(|_| self.space.random(&mut rng)).collect()
    }
}

/// How to choose the poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum How {
    /// The paper's method for an index, mm and rad.
    Tabu(&'static str),
    /// The paper's reference for an index, mm and rad.
    Detmax(&'static str),
    /// The reference for O1 from many starts, with as many iterations in all as the method has.
    Restarts,
    /// Our exchange for O1 in mm and rad among the same candidates.
    Exchange,
    /// The paper's method for O1 on whitened rows.
    WhitenedTabu,
    /// Our exchange for O1 on whitened rows, with corners, grid and polishing.
    Improved,
    /// Candidates drawn at random.
    Random,
}

/// A set to choose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    pub(super) how: How,
    pub(super) n: usize,
    /// Which list of candidates.
    pub(super) list: u64,
    /// Number of candidates in it.
    pub(super) candidates: usize,
}

impl How {
    /// Lists that a calibration is repeated over: as many as are asked for, and more random sets.
    pub(super) fn lists(self, context: &ReproductionContext<'_>) -> u64 {
        if self == Self::Random { context.random_sets() } else { context.settings.lists }
    }
}

impl Wanted {
    /// A set of `n` poses from each of the first `lists` lists, with the candidates of the settings.
    pub(super) fn over(context: &ReproductionContext<'_>, how: How, n: usize, lists: u64) -> Vec<Self> {
        (0..lists).map(|list| Self { how, n, list, candidates: context.settings.candidates }).collect()
    }
}

/// A chosen set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Chosen {
    coordinates: Vec<[f64; 6]>,
    /// The index that was asked for.
    pub(super) value: f64,
    pub(super) iterations: usize,
    pub(super) trace: Vec<f64>,
}

impl Chosen {
    pub(super) fn poses(&self) -> Vec<Pose> {
        self.coordinates.iter().map(Pose::from_coordinates).collect()
    }

    /// Members that are also in the other set.
    pub(super) fn shared_with(&self, other: &Self) -> usize {
        self.coordinates.iter().filter(|q| other.coordinates.contains(q)).count()
    }
}

/// Chooses sets, each once, in parallel.
pub(super) fn choose(
    context: &ReproductionContext<'_>,
    place: &Place,
    what: &str,
    wanted: &[Wanted],
) -> Result<Vec<Chosen>, ReproduceError> {
    let key = |w: &Wanted| {
        let Wanted { how, n, list, candidates } = w;
        format!("{}: {how:?}, {n} poses, list {list} of {candidates}", place.name)
    };
    context.units(&format!("choosing poses for {what}"), wanted, key, |w| one(context, place, w))
}

fn one(context: &ReproductionContext<'_>, place: &Place, wanted: &Wanted) -> Result<Chosen, ReproduceError> {
    let Wanted { how, n, list, candidates } = *wanted;
    let whitened = matches!(how, How::Improved | How::WhitenedTabu);
    let campaign = place.campaign(if whitened { Scaling::Whitened } else { Scaling::Paper })?;
    let seed = context.seed(Purpose::Candidates, list);
    let sources = Sources { random: candidates, corners_and_grid: how == How::Improved, seed, ..Sources::default() };
    let candidates = Candidates::collect(&campaign, &sources)?;
    let named = match how {
        How::Tabu(name) | How::Detmax(name) => index(name),
        _ => None,
    };
    let index: &dyn ObservabilityIndex = named.as_deref().unwrap_or(&O1);
    let problem = Problem {
        campaign: &campaign,
        candidates: &candidates,
        index,
        given: &[],
        count: n,
        seed: context.seed(Purpose::Search, list),
        watch: &|_| {},
    };
    let tabu = TabuDetmax { length: paper::TABU_LENGTH, iterations: paper::TABU_ITERATIONS };
    let choice = match how {
        How::Tabu(_) | How::WhitenedTabu => tabu.select(&problem)?,
        How::Detmax(_) => Detmax::default().select(&problem)?,
        How::Restarts => restarts(context, &problem, list)?,
        How::Exchange => Exchange { polish: false, ..Exchange::default() }.select(&problem)?,
        How::Improved => Exchange::default().select(&problem)?,
        How::Random => {
            let drawn = sample(&mut stream(context.seed(Purpose::RandomSets, list), 0), candidates.len(), n).into_vec();
            Choice { poses: problem.poses(&drawn), iterations: 0, trace: Vec::new() }
        }
    };
    let value = problem.value_of(&choice.poses);
    let coordinates = choice.poses.iter().map(Pose::coordinates).collect();
    Ok(Chosen { coordinates, value, iterations: choice.iterations, trace: choice.trace })
}

/// Plain DETMAX from new random sets until it has had as many iterations as the tabu search.
fn restarts(context: &ReproductionContext<'_>, problem: &Problem<'_>, list: u64) -> Result<Choice, ReproduceError> {
    let mut best: Option<(f64, Choice)> = None;
    let mut iterations = 0;
    let mut start = 0;
    while iterations < paper::TABU_ITERATIONS {
        let left = paper::TABU_ITERATIONS - iterations;
        let seed = context.seed(Purpose::Restarts, (list << 16) | start);
        let choice = Detmax { iterations: left }.select(&Problem { seed, ..*problem })?;
        iterations += choice.iterations.max(1);
        start += 1;
        let value = problem.value_of(&choice.poses);
        if best.as_ref().is_none_or(|(b, _)| value > *b) {
            best = Some((value, choice));
        }
    }
    // The loop runs at least once.
    let choice = best.map_or_else(|| Choice { poses: Vec::new(), iterations, trace: Vec::new() }, |(_, choice)| choice);
    Ok(Choice { iterations: start as usize, ..choice })
}

/// O1 (mm and rad) of sets of candidates of a list, given by their numbers.
pub(super) fn indices_of_random_sets(
    context: &ReproductionContext<'_>,
    place: &Place,
    list: u64,
    sets: u64,
    draw: impl Fn(u64) -> Vec<usize> + Sync,
) -> Result<Vec<f64>, ReproduceError> {
    let campaign = place.campaign(Scaling::Paper)?;
    let sources = Sources {
        random: context.settings.candidates,
        seed: context.seed(Purpose::Candidates, list),
        ..Sources::default()
    };
    let candidates = Candidates::collect(&campaign, &sources)?;
    let value = |set: u64| PoseSet::new(&candidates.pool, &O1, &[], &draw(set)).value();
    Ok((0..sets).into_par_iter().map(value).collect())
}
