//! What a campaign could tell, before anything is measured.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use std::sync::Arc;

use super::prediction::{PredictedError, predicted_errors};
use super::problem::CalibrationProblem;
use super::result::{linearized, pseudo_inverse};
use super::weak_directions::{DataSpectrum, WeakDirection, weak_directions};
use super::{Convention, IdentifyError, Prior, Task};
use crate::conditions::Conditions;
use crate::measurement::{Dataset, Noise, PoseMeasurement, Sample};
use crate::mechanism::{Mechanism, Workspace};
use crate::pose::Pose;

/// What measuring full poses at given places would tell.
#[derive(Clone, Debug)]
pub struct Prospect {
    /// The poses.
    pub poses: Vec<Pose>,
    /// σ of each parameter, SI; `None` if it would not be determined.
    pub sigma: Vec<Option<f64>>,
    /// True if the tolerances are needed as a prior.
    pub prior: bool,
    /// Directions that these poses would not decide.
    pub weak: Vec<WeakDirection>,
    /// Predicted error of the calibrated pose over the workspace.
    pub predicted: Option<PredictedError>,
}

/// Sets of corners that are compared.
const DRAWS: usize = 100;

/// Looks ahead at `n` poses on corners of the workspace: the best of a hundred random sets by the volume of what
/// they determine, `∏ σᵢ` of the whitened Jacobian.
///
/// # Errors
/// [`IdentifyError`] if a corner cannot be reached.
pub fn prospect(
    mechanism: &dyn Mechanism,
    workspace: &Workspace,
    noise: &Noise,
    n: usize,
    seed: u64,
) -> Result<Prospect, IdentifyError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let corners = workspace.corners();
    let mut best: Option<(f64, Vec<Pose>, DMatrix<f64>)> = None;
    for _ in 0..DRAWS {
        let mut order: Vec<usize> = (0..corners.len()).collect();
        order.shuffle(&mut rng);
        // Workspaces of low dimension have fewer corners than poses are wanted; they are then measured again.
        let poses: Vec<Pose> = order.iter().cycle().take(n).map(|k| corners[*k]).collect();
        let jacobian = whitened_jacobian(mechanism, &poses, workspace, noise)?;
        let spectrum = DataSpectrum::of(mechanism, &jacobian);
        let volume: f64 = spectrum.values.iter().map(|s| s.max(1e-300).ln()).sum();
        if best.as_ref().is_none_or(|(v, ..)| volume > *v) {
            best = Some((volume, poses, jacobian));
        }
    }
    let Some((_, poses, jacobian)) = best else { return Err(IdentifyError::Empty) };
    let spectrum = DataSpectrum::of(mechanism, &jacobian);
    let tolerances = Prior::from_tolerance(mechanism, Convention::Stated).ok();
    let prior = tolerances.filter(|_| spectrum.smallest() < super::DECIDED);
    let mut rows = jacobian;
    if let Some(prior) = &prior {
        let (data, n) = rows.shape();
        rows = rows.resize_vertically(data + prior.rows(), 0.0);
        let mut residual = DVector::zeros(data + prior.rows());
        prior.write(&DVector::zeros(n), data, &mut residual, &mut rows);
    }
    let (inverse, _, determined) = pseudo_inverse(&rows);
    let covariance = &inverse * inverse.transpose();
    let drawn: Vec<Pose> = (0..200).map(|_| workspace.random(&mut rng)).collect();
    Ok(Prospect {
        sigma: (0..determined.len()).map(|k| determined[k].then(|| covariance[(k, k)].sqrt())).collect(),
        prior: prior.is_some(),
        weak: weak_directions(mechanism, &spectrum),
        predicted: predicted_errors(mechanism, &covariance, &drawn, &workspace.convention),
        poses,
    })
}

/// Jacobian of full poses measured at `poses`.
fn whitened_jacobian(
    mechanism: &dyn Mechanism,
    poses: &[Pose],
    workspace: &Workspace,
    noise: &Noise,
) -> Result<DMatrix<f64>, IdentifyError> {
    let at = Conditions::unknown();
    let mut samples = Vec::with_capacity(poses.len());
    for (row, pose) in poses.iter().enumerate() {
        let joints = mechanism.inverse(mechanism.values(), pose, &at).map_err(|cause| IdentifyError::Sample {
            row,
            label: String::new(),
            cause,
        })?;
        samples.push(Sample { row, joints, ..Sample::default() });
    }
    let model = PoseMeasurement::full(workspace.convention, poses, noise.position, noise.rotation);
    let data = Dataset::new(samples, Arc::new(model), *noise);
    let mut problem = CalibrationProblem::new(&Task::new(mechanism, &data), None, 1.0)?;
    let start = problem.start();
    Ok(linearized(&mut problem, &start)?.1)
}
