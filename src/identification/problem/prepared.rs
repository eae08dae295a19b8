//! What stays the same of each sample, however often it is evaluated.

use nalgebra::{DMatrix, DVector};

use crate::identification::error::IdentifyError;
use crate::identification::problem::redundancy::Redundancy;
use crate::identification::problem::start::sample_error;
use crate::identification::problem::whitening::Whitening;
use crate::identification::task::Weights;
use crate::measurement::{Dataset, RowKind, Rows};
use crate::mechanism::{KinematicsError, Mechanism, MotionBlock};
use crate::pose::Pose;

/// A sample before the first iteration.
pub(crate) struct Prepared {
    /// Kind of each of its rows, those of a redundant mechanism included.
    pub(crate) kinds: Vec<RowKind>,
    /// Its pose at the start.
    pub(crate) pose: Pose,
    /// Covariance of its rows (k × k), joints included, for the noise as stated.
    pub(crate) covariance: DMatrix<f64>,
    /// What brings them to unit covariance, or to millimetres and radians.
    pub(crate) whitening: Whitening,
    /// Combinations of the closure that are rows in addition to the reading: `N` (m × rows), see [`Redundancy`].
    pub(crate) combinations: Option<DMatrix<f64>>,
}

/// Prepares the samples of a dataset at the values of the mechanism.
pub(crate) struct Preparation<'a> {
    pub(crate) mechanism: &'a dyn Mechanism,
    pub(crate) data: &'a Dataset,
    /// Start values of the own parameters of the measurement.
    pub(crate) own: &'a [f64],
    pub(crate) weights: Weights,
    pub(crate) redundancy: Option<&'a mut Redundancy>,
}

impl Preparation<'_> {
    /// All samples, which have these poses.
    pub(crate) fn samples(mut self, poses: &[Pose]) -> Result<Vec<Prepared>, IdentifyError> {
        let mut block = MotionBlock::sized_for(self.mechanism);
        poses.iter().enumerate().map(|(k, pose)| self.sample(k, pose, &mut block)).collect()
    }

    fn sample(&mut self, k: usize, pose: &Pose, block: &mut MotionBlock) -> Result<Prepared, IdentifyError> {
        let sample = self.data.sample(k);
        let mut kinds = self.data.rows(k);
        let extra = self.redundancy.as_deref_mut().map(|r| (r.combinations(self.mechanism, sample, pose), r.rows()));
        // Closure residuals are lengths.
        kinds.resize(kinds.len() + extra.as_ref().map_or(0, |(_, rows)| *rows), RowKind::Position);
        let combinations = extra.map(|(combinations, _)| combinations);
        let covariance = self
            .covariance(k, pose, combinations.as_ref(), block)
            .map_err(|cause| sample_error(self.data, k, cause))?;
        let whitening = match self.weights {
            Weights::MillimetresAndRadians => {
                let unit = kinds.iter().map(|kind| if *kind == RowKind::Position { 1e3 } else { 1.0 });
                Whitening::Diagonal(DVector::from_iterator(kinds.len(), unit))
            }
            Weights::Noise => Whitening::of(&covariance).ok_or(IdentifyError::Covariance { row: sample.row })?,
        };
        Ok(Prepared { kinds, pose: *pose, covariance, whitening, combinations })
    }

    /// The closure residual has covariance `J₁ Σ_q J₁ᵀ + J_j Σ_j J_jᵀ`; seen from the reading the second term is
    /// `H (J₁⁻¹ J_j) Σ_j (J₁⁻¹ J_j)ᵀ Hᵀ`.
    fn covariance(
        &mut self,
        k: usize,
        pose: &Pose,
        combinations: Option<&DMatrix<f64>>,
        block: &mut MotionBlock,
    ) -> Result<DMatrix<f64>, KinematicsError> {
        let mut covariance = self.data.covariance(k);
        let joint = self.data.noise.joint;
        if !(joint > 0.0) {
            return Ok(covariance);
        }
        let (sample, c) = (self.data.sample(k), self.mechanism.values());
        self.mechanism.motion_block(c, &sample.joints, pose, &sample.conditions, block)?;
        let mut rows = Rows::sized(covariance.nrows(), self.own.len());
        self.data.evaluate(k, pose, self.own, &mut rows);
        let mut seen = &rows.motion * &block.joints;
        if let (Some(extra), Some(combinations)) = (self.redundancy.as_deref_mut(), combinations) {
            extra.evaluate(self.mechanism, c, combinations, sample, pose);
            let (k, e) = (seen.nrows(), extra.rows());
            covariance = covariance.resize(k + e, k + e, 0.0);
            seen = seen.insert_rows(k, e, 0.0);
            seen.rows_mut(k, e).copy_from(&extra.joints);
        }
        covariance += &seen * seen.transpose() * (joint * joint);
        Ok(covariance)
    }
}
