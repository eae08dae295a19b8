//! Predicted accuracy of a calibration with chosen poses.

use nalgebra::DMatrix;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use super::{Campaign, SelectionError};
use crate::observability::{DECIDED, PoseError, PredictedError, Scaling, Spectrum, stacked};
use crate::pose::Pose;

/// Poses at which errors are predicted if the user names none.
const TARGETS: usize = 200;

/// Predicts the error of the calibrated pose over target poses.
#[derive(Clone, Debug)]
pub struct Forecaster<'a> {
    campaign: Campaign<'a>,
    /// Motion (6 × L) of the stated point and of the platform per tolerance, at each target.
    motion: Vec<DMatrix<f64>>,
    /// Motion as coordinates over their noise.
    weighted: Vec<DMatrix<f64>>,
}

/// The prediction for one set of poses.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Forecast {
    /// Error of the calibrated pose over the targets.
    pub error: PredictedError,
    /// True if the tolerances were needed as a prior.
    pub prior: bool,
    /// Spectrum of the data alone, in parameters over their tolerance.
    pub spectrum: Spectrum,
    /// Covariance of the parameters in units of their tolerances.
    pub covariance: DMatrix<f64>,
}

impl<'a> Forecaster<'a> {
    /// For a whitened campaign and the poses that matter, or 200 drawn from the workspace if there are none.
    ///
    /// # Errors
    /// [`SelectionError::NoTarget`] if no target can be reached.
    pub fn new(campaign: Campaign<'a>, targets: &[Pose]) -> Result<Self, SelectionError> {
        debug_assert_eq!(campaign.scaling, Scaling::Whitened);
        let drawn: Vec<Pose>;
        let targets = if targets.is_empty() {
            let mut rng = ChaCha8Rng::seed_from_u64(0);
            drawn = (0..TARGETS).map(|_| campaign.consistent(&campaign.workspace.random(&mut rng))).collect();
            &drawn
        } else {
            targets
        };
        let reached: Vec<&Pose> = targets.iter().filter(|p| campaign.block(p).is_ok()).collect();
        let motion: Vec<DMatrix<f64>> = reached.iter().filter_map(|p| campaign.motion(p).ok()).collect();
        let weighted: Vec<DMatrix<f64>> = reached.iter().filter_map(|p| campaign.weighted_rates(p).ok()).collect();
        if motion.is_empty() {
            return Err(SelectionError::NoTarget(targets.len()));
        }
        Ok(Self { campaign, motion, weighted })
    }

    /// The index that this prediction is, over the directions that candidates see.
    pub fn index(&self, visible: &DMatrix<f64>, prior: bool) -> PoseError {
        PoseError::new(&self.weighted, visible, prior)
    }

    /// The campaign with whitened rows.
    pub fn campaign(&self) -> &Campaign<'a> {
        &self.campaign
    }

    /// Spectrum of measuring these poses, in parameters over their tolerance.
    pub fn spectrum(&self, poses: &[Pose]) -> Spectrum {
        Spectrum::of(&self.rows(poses), poses.len(), true)
    }

    fn rows(&self, poses: &[Pose]) -> DMatrix<f64> {
        let blocks: Vec<DMatrix<f64>> =
            poses.iter().filter_map(|p| self.campaign.block(p).ok().and_then(|b| b.rows())).collect();
        stacked(&blocks, self.campaign.columns().len(), false)
    }

    /// Predicted accuracy from measuring these poses, with the tolerances as prior where `calibrate` would use them.
    pub fn forecast(&self, poses: &[Pose]) -> Forecast {
        let spectrum = self.spectrum(poses);
        let prior = spectrum.values.iter().any(|s| *s < DECIDED);
        let v = &spectrum.directions;
        let mut scaled = v.clone();
        for (mut column, s) in scaled.column_iter_mut().zip(&spectrum.values) {
            column.unscale_mut(s * s + if prior { 1.0 } else { 0.0 });
        }
        let covariance = scaled * v.transpose();
        Forecast { error: PredictedError::over(&self.motion, &covariance), prior, spectrum, covariance }
    }
}
