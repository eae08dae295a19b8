//! The least-squares problem behind every identifier.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use crate::identification::error::IdentifyError;
use crate::identification::problem::belief::Belief;
use crate::identification::problem::prepared::{Preparation, Prepared};
use crate::identification::problem::prior::{Prior, PriorPolicy};
use crate::identification::problem::redundancy::Redundancy;
use crate::identification::problem::spectrum::ScaledRows;
use crate::identification::problem::start::{self, own_start, poses_from_home};
use crate::identification::task::{Task, Weights};
use crate::measurement::{Dataset, RowKind, Rows};
use crate::mechanism::{Mechanism, MotionBlock, ParameterSpec};
use crate::pose::Pose;

/// Whitened residual `W(ŷ(x) - y)` of a dataset, with prior rows `(x - x₀)/σ₀` below it.
///
/// Unknowns: the parameters of the mechanism, then those of the measurement. Forward kinematics of each sample
/// starts where it ended the time before, and is left out where the parameters of the mechanism are those of that time.
pub struct CalibrationProblem<'a> {
    pub(super) mechanism: &'a dyn Mechanism,
    pub(super) data: Dataset,
    pub(super) policy: PriorPolicy,
    pub(super) weights: Weights,
    pub(super) belief: Belief,
    pub(super) samples: Arc<[Prepared]>,
    /// Which of the prepared samples take part.
    pub(super) kept: Vec<usize>,
    pub(super) prior: Option<Prior>,
    /// σ of the readings over the stated one.
    pub(super) noise_scale: f64,
    /// Square root of the weight of each sample; one but for robust fits.
    pub(super) sample_weights: Vec<f64>,
    /// Rows that more than six closure equations add to each sample.
    pub(super) redundancy: Option<Redundancy>,
    pub(super) poses: Vec<Pose>,
    /// The parameters of the mechanism that these poses belong to.
    pub(super) solved_at: Option<Vec<f64>>,
    pub(super) start: DVector<f64>,
    /// The start or, where that does not reach all samples, values near it that do.
    pub(super) first: DVector<f64>,
    pub(super) guess: DVector<f64>,
    /// What the data say at the start, once it was asked for.
    pub(super) at_start: Option<ScaledRows>,
    pub(super) block: MotionBlock,
    /// Readings of the sample at hand; their number rarely changes from one sample to the next.
    pub(super) rows: Rows,
}

impl<'a> CalibrationProblem<'a> {
    /// The problem of a task, for the noise as stated and without a prior.
    ///
    /// # Errors
    /// [`IdentifyError`] if a sample has no pose at the start or its noise is not positive.
    pub fn new(task: &Task<'a>) -> Result<Self, IdentifyError> {
        Self::from_poses(task.mechanism, task, poses_from_home(task.mechanism, task.data))
    }

    /// The problem of a task for a mechanism whose samples have these poses at the start.
    pub(crate) fn from_poses(
        mechanism: &'a dyn Mechanism,
        task: &Task<'_>,
        from_home: Vec<Result<Pose, IdentifyError>>,
    ) -> Result<Self, IdentifyError> {
        let data = task.data;
        if data.is_empty() {
            return Err(IdentifyError::Empty);
        }
        let start::Start { poses, near } = start::start(from_home, mechanism, data, task.conventions)?;
        let expected = data.model().nuisance_parameters().len();
        let own = if expected > 0 { own_start(data, &poses) } else { Vec::new() };
        if own.len() != expected || own.iter().any(|v| !v.is_finite()) {
            return Err(IdentifyError::Start { expected, found: own.len() });
        }
        let c = mechanism.values();
        let from = |c: &[f64]| DVector::from_iterator(c.len() + expected, c.iter().chain(&own).copied());
        let start = from(c);
        let first = near.as_ref().map_or_else(|| start.clone(), |near| from(&near.values));
        let mut redundancy = Redundancy::of(mechanism, data.noise.joint);
        let (own, weights) = (own.as_slice(), task.weights);
        let samples = Preparation { mechanism, data, own, weights, redundancy: redundancy.as_mut() }.samples(&poses)?;
        Ok(Self {
            mechanism,
            data: data.clone(),
            policy: task.prior,
            weights,
            belief: Belief::stated(task.conventions),
            kept: (0..samples.len()).collect(),
            prior: None,
            noise_scale: 1.0,
            sample_weights: vec![1.0; samples.len()],
            rows: Rows::sized(data.rows(0).len(), expected),
            samples: samples.into(),
            redundancy,
            solved_at: Some(first.as_slice()[..c.len()].to_vec()),
            poses: near.map_or(poses, |near| near.poses),
            guess: first.clone(),
            first,
            start,
            at_start: None,
            block: MotionBlock::sized_for(mechanism),
        })
    }

    /// The problem of some of its samples, without a prior and with the noise as stated. It starts at the same values, and
    /// its iterations begin where `guess` says.
    pub(crate) fn subset(&self, positions: &[usize], guess: &DVector<f64>) -> Self {
        let kept: Vec<usize> = positions.iter().map(|k| self.kept[*k]).collect();
        Self {
            mechanism: self.mechanism,
            data: self.data.subset(positions),
            policy: self.policy,
            weights: self.weights,
            belief: self.belief.clone(),
            samples: Arc::clone(&self.samples),
            prior: None,
            noise_scale: 1.0,
            sample_weights: vec![1.0; kept.len()],
            redundancy: self.redundancy.clone(),
            poses: positions.iter().map(|k| self.poses[*k]).collect(),
            solved_at: self.solved_at.clone(),
            start: self.start.clone(),
            first: self.first.clone(),
            guess: guess.clone(),
            at_start: None,
            block: self.block.clone(),
            rows: self.rows.clone(),
            kept,
        }
    }

    /// How the tolerances are taken, if they are the prior.
    pub(crate) fn belief(&self) -> &Belief {
        &self.belief
    }

    /// Takes the tolerances in another way from now on.
    pub(crate) fn believe(&mut self, belief: Belief) {
        self.belief = belief;
    }

    /// With a prior, or without.
    #[must_use]
    pub fn with_prior(mut self, prior: Option<Prior>) -> Self {
        self.prior = prior;
        self
    }

    /// Multiplies every σ of the readings, as they are stated, by `scale`.
    pub fn scale_noise(&mut self, scale: f64) {
        self.noise_scale = scale;
    }

    /// Multiplies the rows of each sample by the square root of its weight.
    pub fn weigh_samples(&mut self, weights: &[f64]) {
        self.sample_weights = weights.iter().map(|w| w.sqrt()).collect();
    }

    /// Where the parameters start: the values of the mechanism, then those of the measurement.
    pub fn start(&self) -> DVector<f64> {
        self.start.clone()
    }

    /// Where an iteration had best begin: at the start, or near a minimum that is known.
    pub fn guess(&self) -> DVector<f64> {
        self.guess.clone()
    }

    /// Where an iteration begins of which nothing is known: at the start or, if the mechanism as it is given does not reach all
    /// samples, at values near it that do.
    pub fn first_guess(&self) -> DVector<f64> {
        self.first.clone()
    }

    /// Begins anew where the closure fits the measured poses best, from where an iteration has a shorter way than from the
    /// mechanism as it is given. False if the readings give too few poses.
    pub(crate) fn begin_at_closure(&mut self) -> bool {
        let at_start: Vec<Result<Pose, IdentifyError>> = self.prepared().map(|s| Ok(s.pose)).collect();
        let conventions = self.belief.conventions;
        let Some(near) = start::closure_start(self.mechanism, &self.data, conventions, &at_start) else { return false };
        self.first.rows_mut(0, near.values.len()).copy_from(&DVector::from_column_slice(&near.values));
        self.guess.clone_from(&self.first);
        self.poses = near.poses;
        self.solved_at = Some(near.values);
        true
    }

    /// Lets the next iteration begin here.
    pub fn begin_at(&mut self, guess: DVector<f64>) {
        self.guess = guess;
    }

    /// The mechanism; its values are the start and the centre of a prior.
    pub fn mechanism(&self) -> &'a dyn Mechanism {
        self.mechanism
    }

    /// The samples.
    pub fn data(&self) -> &Dataset {
        &self.data
    }

    /// Where a prior comes from.
    pub fn policy(&self) -> PriorPolicy {
        self.policy
    }

    /// How rows are weighted.
    pub fn weights(&self) -> Weights {
        self.weights
    }

    /// σ of the readings over the stated one, for which the rows have unit variance.
    pub fn noise_scale(&self) -> f64 {
        self.noise_scale
    }

    /// Data rows, without those of the prior.
    pub fn data_rows(&self) -> usize {
        self.prepared().map(|s| s.kinds.len()).sum()
    }

    /// Number of parameters of the mechanism.
    pub fn mechanism_parameters(&self) -> usize {
        self.mechanism.parameters().len()
    }

    /// Specifications of all unknowns.
    pub fn parameters(&self) -> impl Iterator<Item = &ParameterSpec> {
        self.mechanism.parameters().iter().chain(self.data.model().nuisance_parameters())
    }

    /// The prior, if there is one.
    pub fn prior(&self) -> Option<&Prior> {
        self.prior.as_ref()
    }

    /// First data row of each sample, and the number of its rows.
    pub fn sample_rows(&self) -> Vec<(usize, usize)> {
        let mut first = 0;
        let next = |sample: &Prepared| {
            let range = (first, sample.kinds.len());
            first += sample.kinds.len();
            range
        };
        self.prepared().map(next).collect()
    }

    /// Kind of each data row.
    pub fn row_kinds(&self) -> Vec<RowKind> {
        self.prepared().flat_map(|s| s.kinds.iter().copied()).collect()
    }

    /// For each sample the matrix (k × k) that turns whitened rows back into SI.
    pub fn unwhitening(&self) -> Vec<DMatrix<f64>> {
        let factor = 1.0 / self.row_factor();
        self.prepared().map(|s| s.whitening.inverse() * factor).collect()
    }

    /// `Σₖ Aₖ Σₖ Aₖᵀ`: covariance of `A r` for the whitened residual `r` and the noise as stated, with the columns of `a`
    /// in the order of the rows. Rows of a prior have unit covariance.
    pub fn covariance_through(&self, a: &DMatrix<f64>) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(a.nrows(), a.nrows());
        let mut next = 0;
        for ((first, n), (sample, weight)) in
            self.sample_rows().into_iter().zip(self.prepared().zip(&self.sample_weights))
        {
            let part = a.columns(first, n) * sample.whitening.to_matrix() * (*weight * self.row_factor());
            sum += &part * &sample.covariance * part.transpose();
            next = first + n;
        }
        let rest = a.columns(next, a.ncols() - next);
        sum + rest * rest.transpose()
    }

    /// What every row is multiplied by in addition to its whitening, which is that of the noise as stated.
    pub(super) fn row_factor(&self) -> f64 {
        match self.weights {
            Weights::Noise => 1.0 / self.noise_scale,
            Weights::MillimetresAndRadians => 1.0,
        }
    }

    /// The samples that take part.
    pub(super) fn prepared(&self) -> impl Iterator<Item = &Prepared> {
        self.kept.iter().map(|k| &self.samples[*k])
    }

    /// Poses that the last evaluation predicted.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// All of its samples, as [`subset`](Self::subset) takes some of them.
    pub(super) fn whole(&self) -> Self {
        let all: Vec<usize> = (0..self.kept.len()).collect();
        self.subset(&all, &self.guess)
    }

    /// The same samples with rows weighted by the noise as stated, and no prior.
    pub(super) fn by_noise(&self) -> Result<Self, IdentifyError> {
        if self.weights == Weights::Noise {
            return Ok(self.whole());
        }
        let (mechanism, data, prior, conventions) = (self.mechanism, &self.data, self.policy, self.belief.conventions);
        let task = Task { mechanism, data, prior, weights: Weights::Noise, conventions };
        let mut plain = Self::from_poses(mechanism, &task, self.prepared().map(|s| Ok(s.pose)).collect())?;
        plain.belief.clone_from(&self.belief);
        plain.start.clone_from(&self.start);
        plain.first.clone_from(&self.first);
        plain.poses.clone_from(&self.poses);
        plain.solved_at.clone_from(&self.solved_at);
        Ok(plain)
    }

    /// Weights rows by the noise from now on, whatever the task said.
    ///
    /// # Errors
    /// [`IdentifyError::Covariance`] if the noise of a sample is not positive.
    pub fn weigh_by_noise(&mut self) -> Result<(), IdentifyError> {
        if self.weights != Weights::Noise {
            *self = self.by_noise()?;
        }
        Ok(())
    }
}
