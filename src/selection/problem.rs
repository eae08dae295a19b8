//! Input and result of a selector.

use std::fmt::Debug;

use nalgebra::DMatrix;
use rand::rngs::ChaCha8Rng;
use rand::seq::index::sample;

use super::{Campaign, Candidates, SelectionError};
use crate::observability::{O1, ObservabilityIndex, PoseSet, Spectrum, stacked};
use crate::pose::Pose;

/// Choose `count` of the candidates so that the index of them and the given poses together is best.
#[derive(Clone, Copy)]
pub struct Problem<'a> {
    /// Turns any pose of the workspace into a block; for selectors that move poses.
    pub campaign: &'a Campaign<'a>,
    /// Candidates, each of which may be chosen once.
    pub candidates: &'a Candidates,
    /// Index to optimise.
    pub index: &'a dyn ObservabilityIndex,
    /// Rows (6 × L' each, along the visible directions) of poses that are measured anyway.
    pub given: &'a [DMatrix<f64>],
    /// Number of poses to choose.
    pub count: usize,
    /// Random seed.
    pub seed: u64,
    /// Told of progress, from any thread.
    pub watch: &'a (dyn Fn(Step) + Sync),
}

/// How far a selector has come.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Step {
    /// Steps done.
    pub done: usize,
    /// Steps in all, as far as it is known.
    pub total: usize,
}

/// Result of a selector.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The poses; a selector may have moved them off the candidates.
    pub poses: Vec<Pose>,
    /// Iterations it took, in the selector's own count.
    pub iterations: usize,
    /// Value of the index for the first set, then after each of them: one number more than `iterations`.
    pub trace: Vec<f64>,
}

/// A choice, and which candidates it took.
#[derive(Clone, Debug, PartialEq)]
pub struct Numbered {
    /// The choice.
    pub choice: Choice,
    /// For each of its poses the number of the candidate that it is; `None` if it was moved off the candidates.
    pub numbers: Vec<Option<usize>>,
}

/// A way to choose poses.
pub trait PoseSelector: Debug + Send + Sync {
    /// Name on the command line and in results.
    fn name(&self) -> &str;

    /// True if it wants the corners of the workspace and the grid among its candidates.
    fn wants_corners(&self) -> bool {
        false
    }

    /// Chooses `problem.count` different feasible poses. The same problem gives the same choice, on any number of
    /// threads.
    ///
    /// # Errors
    /// [`SelectionError`] if there are too few candidates.
    fn select(&self, problem: &Problem<'_>) -> Result<Choice, SelectionError>;

    /// The same choice with the number of the candidate that each pose is. Those of a selector that does not keep them
    /// are looked up by place.
    ///
    /// # Errors
    /// Those of [`select`](Self::select).
    fn select_numbered(&self, problem: &Problem<'_>) -> Result<Numbered, SelectionError> {
        let choice = self.select(problem)?;
        let numbers = choice.poses.iter().map(|pose| problem.candidates.at(pose)).collect();
        Ok(Numbered { choice, numbers })
    }
}

impl<'a> Problem<'a> {
    /// A set of these candidates together with the given poses.
    pub fn set(&self, members: &[usize]) -> PoseSet<'a> {
        PoseSet::new(&self.candidates.pool, self.index, self.given, members)
    }

    /// `count` candidates drawn without repetition.
    ///
    /// # Errors
    /// [`SelectionError::TooFewCandidates`].
    pub fn draw(&self, rng: &mut ChaCha8Rng) -> Result<Vec<usize>, SelectionError> {
        self.check()?;
        Ok(sample(rng, self.candidates.len(), self.count).into_vec())
    }

    /// That there are as many candidates as poses to choose.
    ///
    /// # Errors
    /// [`SelectionError::TooFewCandidates`].
    pub fn check(&self) -> Result<(), SelectionError> {
        let found = self.candidates.len();
        if found < self.count { Err(SelectionError::TooFewCandidates { wanted: self.count, found }) } else { Ok(()) }
    }

    /// A set to start from when a random one determines nothing: poses are added for the volume of what they
    /// determine, a ridge standing in for what is missing, beyond the number that determines everything, and the
    /// least useful are then removed.
    pub fn greedy(&self) -> Vec<usize> {
        let volume = Problem { index: &O1, ..*self };
        let mut set = volume.set(&[]);
        let enough = self.count.max(self.candidates.pool.directions().div_ceil(6) + 5).min(self.candidates.len());
        while set.members().len() < enough {
            let Some(best) = set.best_addition() else { break };
            set.add(best.which);
        }
        while set.members().len() > self.count {
            let Some(worst) = set.best_removal() else { break };
            set.remove(worst.which);
        }
        set.members().to_vec()
    }

    /// A start for an improvement: drawn, or greedy if what was drawn determines nothing.
    ///
    /// # Errors
    /// [`SelectionError::TooFewCandidates`].
    pub fn start(&self, rng: &mut ChaCha8Rng) -> Result<Vec<usize>, SelectionError> {
        let drawn = self.draw(rng)?;
        Ok(if self.set(&drawn).is_singular() { self.greedy() } else { drawn })
    }

    /// The index of any poses together with the given ones, from their own blocks.
    pub fn value_of(&self, poses: &[Pose]) -> f64 {
        self.index.value(&self.spectrum_of(poses))
    }

    /// Spectrum of any poses together with the given ones and with the prior of the index.
    pub fn spectrum_of(&self, poses: &[Pose]) -> Spectrum {
        let visible = self.candidates.pool.visible();
        let directions = visible.ncols();
        let own = poses.iter().filter_map(|p| Some(self.campaign.block(p).ok()?.rows()? * visible));
        let blocks: Vec<DMatrix<f64>> = own.chain(self.given.iter().cloned()).collect();
        let rows = stacked(&blocks, directions, self.index.prior());
        Spectrum::of(&rows, blocks.len(), self.index.needs_directions())
    }

    /// Rows that belong to every set, as [`relax`](super::relax) wants them: those of the given poses and of the prior.
    pub fn fixed_rows(&self) -> DMatrix<f64> {
        stacked(self.given, self.candidates.pool.directions(), self.index.prior())
    }

    /// The choice of these candidates, after a search with this trace of values: its first and one for each iteration.
    pub fn choice_of(&self, members: &[usize], trace: Vec<f64>) -> Numbered {
        let iterations = trace.len().saturating_sub(1);
        let choice = Choice { poses: self.poses(members), iterations, trace };
        Numbered { choice, numbers: members.iter().copied().map(Some).collect() }
    }

    /// The poses of candidates.
    pub fn poses(&self, members: &[usize]) -> Vec<Pose> {
        members.iter().map(|k| self.candidates.poses[*k]).collect()
    }
}
