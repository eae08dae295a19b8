//! What the rows of a problem say, and which prior that asks for.

use nalgebra::{DMatrix, DVector};

use crate::identification::error::IdentifyError;
use crate::identification::problem::belief::Group;
use crate::identification::problem::calibration_problem::CalibrationProblem;
use crate::identification::problem::prior::{Prior, PriorPolicy};
use crate::identification::problem::spectrum::ScaledRows;
use crate::identification::task::Weights;
use crate::measurement::TargetFrame;
use crate::solve::{Triangle, linearized};

/// Rows per unknown up to which folding them together costs more than it saves.
const FEW: usize = 8;

impl CalibrationProblem<'_> {
    /// Residual and Jacobian of the data alone at `x`, weighted by the noise as stated.
    ///
    /// # Errors
    /// [`IdentifyError`] if the rows have no value there.
    pub fn data_at(&self, x: &DVector<f64>) -> Result<(DVector<f64>, DMatrix<f64>), IdentifyError> {
        Ok(linearized(&mut self.by_noise()?, x)?)
    }

    /// Residual and Jacobian at `x` of all rows as they are.
    ///
    /// # Errors
    /// [`IdentifyError`] if the rows have no value there.
    pub(crate) fn all_at(&self, x: &DVector<f64>) -> Result<(DVector<f64>, DMatrix<f64>), IdentifyError> {
        let mut same = self.whole().with_prior(self.prior.clone());
        same.noise_scale = self.noise_scale;
        same.sample_weights.clone_from(&self.sample_weights);
        Ok(linearized(&mut same, x)?)
    }

    /// What the data say of each direction of the parameters at the start.
    ///
    /// # Errors
    /// [`IdentifyError`] if the rows have no value there.
    pub(crate) fn at_start(&mut self) -> Result<&ScaledRows, IdentifyError> {
        if self.at_start.is_none() {
            let mut plain = self.by_noise()?;
            plain.poses = self.prepared().map(|s| s.pose).collect();
            plain.solved_at = Some(self.mechanism.values().to_vec());
            let (r, j) = linearized(&mut plain, &self.start)?;
            // A few rows are looked at as they are; many are folded together.
            let rows = if r.len() > FEW * j.ncols() { Triangle::of(&j, &r).jacobian() } else { j };
            self.at_start = Some(ScaledRows::of(self.mechanism, &rows));
        }
        // It was made just above.
        self.at_start.as_ref().ok_or(IdentifyError::Empty)
    }

    /// True if the readings say nothing of a rigid motion of all platform points: the places of the targets take it up.
    fn platform_is_free(&mut self) -> Result<bool, IdentifyError> {
        let [Some(platform), ..] = Group::all(self.mechanism) else { return Ok(false) };
        let rows = self.at_start()?;
        Ok(platform.directions(rows.parameters()).is_some_and(|directions| rows.miss(&directions)))
    }

    /// Takes the prior that the task asks for, where σ of the readings is `noise_scale` times the stated one: with
    /// [`PriorPolicy::Auto`] the tolerances, unless the data decide every direction.
    ///
    /// # Errors
    /// [`IdentifyError::TooFewRows`] if the data alone cannot determine the parameters and there is no prior.
    pub fn choose_prior(&mut self, noise_scale: f64) -> Result<(), IdentifyError> {
        if self.data.row_count() == 0 {
            return Err(IdentifyError::Empty);
        }
        self.belief.platform_held =
            self.data.model().target_frame() == TargetFrame::Identified && self.platform_is_free()?;
        let unweighted = self.weights == Weights::MillimetresAndRadians;
        let tolerances = |p: &Self| Prior::from_tolerance(p.mechanism, &p.belief);
        let policy = self.policy;
        let asked = match policy {
            PriorPolicy::Tolerance if unweighted => return Err(IdentifyError::PriorWithoutWeights),
            PriorPolicy::Tolerance => Some(tolerances(self)?),
            PriorPolicy::Auto if unweighted || self.at_start()?.decided(noise_scale) => None,
            PriorPolicy::Auto => tolerances(self).ok(),
            PriorPolicy::None => None,
        };
        if asked.is_some() {
            self.prior = asked;
            return Ok(());
        }
        let (rows, samples, unknowns) = (self.data.row_count(), self.data.len(), self.start.len());
        if rows < unknowns {
            let per_sample = rows.div_ceil(samples).max(1);
            return Err(IdentifyError::TooFewRows { rows, samples, unknowns, needed: unknowns.div_ceil(per_sample) });
        }
        let mechanism = self.mechanism;
        self.prior = self.at_start()?.unseen().map(|(scale, directions)| Prior::holding(mechanism, scale, &directions));
        Ok(())
    }
}
