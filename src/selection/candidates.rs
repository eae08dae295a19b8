//! Poses to choose from.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;

use super::campaign::Infeasible;
use super::{Campaign, SelectionError};
use crate::observability::{Block, Pool, PoolBuilder};
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

/// Feasible poses with their joints and blocks, each computed once.
#[derive(Clone, Debug)]
pub struct Candidates {
    /// The poses, SI.
    pub poses: Vec<Pose>,
    /// Their blocks, in the same order.
    pub pool: Pool,
    /// How many poses were looked at.
    pub tried: usize,
    /// Their joints, one pose after the other, SI.
    joints: Vec<f64>,
    origins: Vec<Origin>,
}

/// Where a candidate came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// This entry of [`Sources::listed`], from 0.
    Listed(u32),
    /// A corner of the workspace or a point of its grid, pulled to the centre as far as it had to be.
    Grid,
    /// Drawn from the workspace.
    Drawn,
    /// Added by [`Candidates::with`].
    Further,
}

/// A feasible pose.
struct Placed {
    pose: Pose,
    joints: Vec<f64>,
    block: Block,
}

impl Placed {
    fn new(campaign: &Campaign<'_>, pose: &Pose) -> Result<Self, Infeasible> {
        let pose = campaign.consistent(pose);
        campaign.placed(&pose).map(|(joints, block)| Self { pose, joints, block })
    }
}

/// Poses that are drawn for each that is wanted, at most.
const DRAWS: usize = 200;
/// Candidates are drawn from a stream of their own, so that selectors with the same seed know nothing of them.
const STREAM: u64 = 5 << 32;
/// Poses that are looked at in parallel before they are stored.
const AT_ONCE: usize = 4096;
/// Poses that are nearer to each other are one, m and rad.
const SAME_PLACE: f64 = 1e-12;
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
        let grid = if sources.corners_and_grid { grid(campaign) } else { Vec::new() };
        let expected = sources.listed.len() + grid.len() + sources.random;
        let mut collector = Collector::new(campaign, expected);
        collector.listed(&sources.listed);
        collector.pulled(&grid);
        collector.drawn(sources);
        collector.finish()
    }

    /// These candidates with further feasible poses, such as polished ones, behind them. `None` if their blocks cannot
    /// be stored together.
    pub fn with(&self, campaign: &Campaign<'_>, further: &[Pose]) -> Option<Self> {
        let found = further.iter().map(|pose| campaign.placed(pose).ok()).collect::<Option<Vec<_>>>()?;
        let mut all = self.clone();
        let mut blocks = Vec::with_capacity(found.len());
        for (pose, (joints, block)) in further.iter().zip(found) {
            all.poses.push(*pose);
            all.joints.extend(joints);
            all.origins.push(Origin::Further);
            blocks.push(block);
        }
        if !blocks.is_empty() {
            let members: Vec<usize> = (0..all.poses.len()).collect();
            all.pool = self.pool.joined(&self.pool.alike(&blocks)?, &members);
        }
        all.tried += further.len();
        Some(all)
    }

    /// Some of the candidates, by number, in the same coordinates.
    pub(super) fn only(&self, members: &[usize]) -> Self {
        Self {
            poses: members.iter().map(|k| self.poses[*k]).collect(),
            pool: self.pool.only(members),
            tried: members.len(),
            joints: members.iter().flat_map(|k| self.joints(*k)).copied().collect(),
            origins: members.iter().map(|k| self.origins[*k]).collect(),
        }
    }

    /// The first candidate that lies where a pose does.
    pub(super) fn at(&self, pose: &Pose) -> Option<usize> {
        let near = |p: &Pose| {
            (p.position - pose.position).amax() <= SAME_PLACE
                && (p.rotation.matrix() - pose.rotation.matrix()).amax() <= SAME_PLACE
        };
        self.poses.iter().position(near)
    }

    /// Joints of candidate `k`, SI.
    pub fn joints(&self, k: usize) -> &[f64] {
        let each = self.joints.len() / self.poses.len();
        &self.joints[k * each..(k + 1) * each]
    }

    /// Where candidate `k` came from.
    pub fn origin(&self, k: usize) -> Origin {
        self.origins[k]
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

/// Candidates in the making.
struct Collector<'a> {
    campaign: &'a Campaign<'a>,
    poses: Vec<Pose>,
    joints: Vec<f64>,
    origins: Vec<Origin>,
    pool: PoolBuilder,
    rejected: Rejected,
}

impl<'a> Collector<'a> {
    fn new(campaign: &'a Campaign<'a>, expected: usize) -> Self {
        Self {
            campaign,
            poses: Vec::with_capacity(expected),
            joints: Vec::with_capacity(expected * campaign.mechanism.joints().len()),
            origins: Vec::with_capacity(expected),
            pool: PoolBuilder::new(expected),
            rejected: Rejected::default(),
        }
    }

    /// Keeps the feasible ones in their order.
    fn keep(&mut self, found: Vec<Result<Placed, Infeasible>>, origin: impl Fn(usize) -> Origin) {
        self.rejected.tried += found.len();
        for (k, found) in found.into_iter().enumerate() {
            match found {
                Ok(placed) => {
                    self.poses.push(placed.pose);
                    self.joints.extend(placed.joints);
                    self.origins.push(origin(k));
                    self.pool.push(placed.block);
                }
                Err(reason) => self.rejected.count(reason),
            }
        }
    }

    fn listed(&mut self, poses: &[Pose]) {
        for (part, poses) in poses.chunks(AT_ONCE).enumerate() {
            let found = poses.par_iter().map(|pose| Placed::new(self.campaign, pose)).collect();
            self.keep(found, |k| Origin::Listed(u32::try_from(part * AT_ONCE + k).unwrap_or(u32::MAX)));
        }
    }

    fn pulled(&mut self, points: &[[f64; 6]]) {
        let found = points.par_iter().map(|u| pulled(self.campaign, u)).collect();
        self.keep(found, |_| Origin::Grid);
    }

    fn drawn(&mut self, sources: &Sources) {
        let mut rng = random_stream(sources.seed, STREAM);
        let wanted = self.poses.len() + sources.random;
        let mut draws = 0;
        while self.poses.len() < wanted && draws < DRAWS * sources.random {
            let missing = (wanted - self.poses.len()).min(DRAWS * sources.random - draws).min(AT_ONCE);
            let drawn: Vec<Pose> = (0..missing).map(|_| self.campaign.workspace.random(&mut rng)).collect();
            draws += missing;
            let found = drawn.par_iter().map(|pose| Placed::new(self.campaign, pose)).collect();
            self.keep(found, |_| Origin::Drawn);
        }
    }

    fn finish(self) -> Result<Candidates, SelectionError> {
        let Rejected { tried, unreachable, outside, ill } = self.rejected;
        let Self { poses, joints, origins, .. } = self;
        let none = SelectionError::NoCandidate { tried, unreachable, outside, ill };
        let pool = self.pool.finish().ok_or(none)?;
        Ok(Candidates { poses, pool, tried, joints, origins })
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

/// A point of the workspace (in half-ranges), or the last feasible one on the way to it from the centre.
fn pulled(campaign: &Campaign<'_>, u: &[f64; 6]) -> Result<Placed, Infeasible> {
    let place = |factor: f64| Placed::new(campaign, &campaign.workspace.pose(&u.map(|v| v * factor)));
    let reason = match place(1.0) {
        Ok(placed) => return Ok(placed),
        Err(reason) => reason,
    };
    let mut best = place(0.0).map_err(|_| reason)?;
    let (mut inside, mut outside) = (0.0, 1.0);
    for _ in 0..PULLS {
        let middle = 0.5 * (inside + outside);
        match place(middle) {
            Ok(placed) => (inside, best) = (middle, placed),
            Err(_) => outside = middle,
        }
    }
    Ok(best)
}
