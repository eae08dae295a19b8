//! Poses to choose from.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;

use super::campaign::Infeasible;
use super::{Campaign, SelectionError};
use crate::observability::{Block, Pool};
use crate::pose::Pose;

/// Where candidates come from.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    /// Number of feasible poses drawn uniformly from the workspace.
    pub random: usize,
    /// Corners of the workspace (2 to the number of free coordinates), and the grid of three values for each.
    pub corners_and_grid: bool,
    /// Poses from elsewhere.
    pub listed: Vec<Pose>,
    /// Seed of the draw.
    pub seed: u64,
}

/// Feasible poses with their blocks.
#[derive(Clone, Debug)]
pub struct Candidates {
    /// The poses, SI.
    pub poses: Vec<Pose>,
    /// Their blocks, in the same order.
    pub pool: Pool,
    /// How many poses were looked at.
    pub tried: usize,
}

/// Poses that are drawn for each that is wanted, at most.
const DRAWS: usize = 200;
/// Candidates are drawn from a stream of their own, so that selectors with the same seed know nothing of them.
const STREAM: u64 = 5 << 32;
/// Halvings when an infeasible corner is pulled towards the centre.
const PULLS: usize = 30;

/// Random numbers of a seed that know nothing of those of another stream.
pub(super) fn random_stream(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    rng
}

#[derive(Clone, Copy, Default)]
struct Rejected {
    tried: usize,
    unreachable: usize,
    outside: usize,
    ill: usize,
}

impl Rejected {
    fn count(&mut self, reason: Infeasible) {
        match reason {
            Infeasible::Unreachable => self.unreachable += 1,
            Infeasible::OutsideStroke => self.outside += 1,
            Infeasible::IllConditioned => self.ill += 1,
        }
    }
}

impl Candidates {
    /// Collects feasible candidates: listed ones, then corners and grid, then random ones.
    ///
    /// A corner or a grid point that is not feasible is pulled towards the centre until it is. Random poses are drawn
    /// until there are as many feasible ones as asked for; after 200 draws for each, what was found has to do.
    ///
    /// # Errors
    /// [`SelectionError::NoCandidate`] with the reasons.
    pub fn collect(campaign: &Campaign<'_>, sources: &Sources) -> Result<Self, SelectionError> {
        let mut rejected = Rejected::default();
        let mut poses = Vec::new();
        keep(campaign, sources.listed.clone(), &mut poses, &mut rejected);
        if sources.corners_and_grid {
            let mut grid = pulled(campaign, &grid(campaign), &mut rejected);
            poses.append(&mut grid);
        }
        draw(campaign, sources, &mut poses, &mut rejected);
        let none = || {
            let Rejected { tried, unreachable, outside, ill } = rejected;
            SelectionError::NoCandidate { tried, unreachable, outside, ill }
        };
        Self::of(campaign, poses, rejected.tried).ok_or_else(none)
    }

    /// Feasible poses with their blocks; `None` if there is none.
    fn of(campaign: &Campaign<'_>, poses: Vec<Pose>, tried: usize) -> Option<Self> {
        // A feasible pose has a block; should one fail all the same, it tells nothing.
        let silent = || Block {
            noise: nalgebra::Matrix6::identity(),
            derivatives: nalgebra::Matrix6xX::zeros(campaign.columns().len()),
        };
        let pool = Pool::new(poses.len(), |k| campaign.block(&poses[k]).unwrap_or_else(|_| silent()))?;
        Some(Self { poses, pool, tried })
    }

    /// These candidates with further feasible poses, such as polished ones. `None` if their blocks cannot be stored
    /// together.
    pub fn with(&self, campaign: &Campaign<'_>, further: &[Pose]) -> Option<Self> {
        let poses: Vec<Pose> = self.poses.iter().chain(further).copied().collect();
        Self::of(campaign, poses, self.tried + further.len())
    }

    /// Number of candidates.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// True if there is none; [`collect`](Self::collect) gives at least one.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }
}

/// Appends the feasible ones of `found`, settled.
fn keep(campaign: &Campaign<'_>, found: Vec<Pose>, poses: &mut Vec<Pose>, rejected: &mut Rejected) {
    let judged: Vec<(Pose, Result<(), Infeasible>)> = found
        .into_par_iter()
        .map(|pose| {
            let pose = campaign.consistent(&pose);
            (pose, campaign.feasible(&pose).map(|_| ()))
        })
        .collect();
    for (pose, judged) in judged {
        rejected.tried += 1;
        match judged {
            Ok(()) => poses.push(pose),
            Err(reason) => rejected.count(reason),
        }
    }
}

/// Three values of each free coordinate: the corners first.
fn grid(campaign: &Campaign<'_>) -> Vec<[f64; 6]> {
    let half = &campaign.workspace.half;
    let free: Vec<usize> = (0..6).filter(|k| half[*k] > 0.0).collect();
    let mut points: Vec<[f64; 6]> = (0..3_usize.pow(free.len() as u32))
        .map(|mut number| {
            let mut u = [0.0; 6];
            for k in &free {
                u[*k] = [-1.0, 1.0, 0.0][number % 3];
                number /= 3;
            }
            u
        })
        .collect();
    points.sort_by_key(|u| u.iter().zip(half).filter(|(u, h)| **u == 0.0 && **h > 0.0).count());
    points
}

fn pulled(campaign: &Campaign<'_>, points: &[[f64; 6]], rejected: &mut Rejected) -> Vec<Pose> {
    let place = |u: &[f64; 6], factor: f64| campaign.consistent(&campaign.workspace.pose(&u.map(|v| v * factor)));
    let found: Vec<Result<Pose, Infeasible>> = points
        .par_iter()
        .map(|u| {
            let pose = place(u, 1.0);
            let Err(reason) = campaign.feasible(&pose) else { return Ok(pose) };
            let (mut inside, mut outside) = (0.0, 1.0);
            let mut best = place(u, 0.0);
            if campaign.feasible(&best).is_err() {
                return Err(reason);
            }
            for _ in 0..PULLS {
                let middle = 0.5 * (inside + outside);
                let pose = place(u, middle);
                if campaign.feasible(&pose).is_ok() {
                    (inside, best) = (middle, pose);
                } else {
                    outside = middle;
                }
            }
            Ok(best)
        })
        .collect();
    rejected.tried += points.len();
    let mut poses = Vec::new();
    for result in found {
        match result {
            Ok(pose) => poses.push(pose),
            Err(reason) => rejected.count(reason),
        }
    }
    poses
}

fn draw(campaign: &Campaign<'_>, sources: &Sources, poses: &mut Vec<Pose>, rejected: &mut Rejected) {
    let mut rng = random_stream(sources.seed, STREAM);
    let wanted = poses.len() + sources.random;
    poses.reserve(sources.random);
    let mut draws = 0;
    while poses.len() < wanted && draws < DRAWS * sources.random {
        let missing = (wanted - poses.len()).min(DRAWS * sources.random - draws);
        let drawn: Vec<Pose> = (0..missing).map(|_| campaign.workspace.random(&mut rng)).collect();
        draws += drawn.len();
        keep(campaign, drawn, poses, rejected);
    }
}
