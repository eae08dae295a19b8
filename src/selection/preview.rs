//! Preview of the information from a campaign, before anything is measured.

use crate::measurement::Noise;
use crate::mechanism::{Mechanism, Workspace};
use crate::observability::{O1, Scaling};
use crate::pose::Pose;
use crate::selection::forecast::{Forecast, Forecaster};
use crate::selection::job::{Objective, SelectionTask, select_among};
use crate::selection::{Campaign, Candidates, Exchange, SelectionError, Sources};

/// Predicted information from measuring full poses at well-chosen places.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Preview {
    /// The poses.
    pub poses: Vec<Pose>,
    /// Certified efficiency of the choice.
    pub efficiency: Option<f64>,
    /// What the poses determine, and how accurate the calibrated model will be.
    pub forecast: Forecast,
    /// SI per scaled parameter: the tolerance, or a millimetre (milliradian) where none is stated.
    pub scale: Vec<f64>,
}

/// Stands in for a tolerance that is not stated.
const NO_TOLERANCE: f64 = 1e-3;

/// Looks ahead at `n` poses chosen from corners and grid of the workspace for the largest O1.
///
/// # Errors
/// [`SelectionError`] if no pose can be measured.
pub fn preview(
    mechanism: &dyn Mechanism,
    workspace: &Workspace,
    noise: &Noise,
    n: usize,
    seed: u64,
) -> Result<Preview, SelectionError> {
    let scale: Vec<f64> = mechanism.parameters().iter().map(|s| s.tolerance.unwrap_or(NO_TOLERANCE)).collect();
    let campaign = Campaign::with_columns(mechanism, workspace, Some(noise), Scaling::Whitened, scale.clone())?;
    let sources = Sources { random: 200, corners_and_grid: true, seed, ..Sources::default() };
    let candidates = Candidates::collect(&campaign, &sources)?;
    let forecaster = Forecaster::new(campaign.clone(), &[])?;
    let plan = SelectionTask {
        campaign: &campaign,
        forecaster: Some(&forecaster),
        aim: Objective::Index(&O1),
        given: &[],
        seed,
        watch: &|_| {},
    };
    let selector = Exchange { starts: 4, rounds: 0, polish: false };
    let report = select_among(&plan, &selector, &candidates, n, true)?;
    let forecast = report.forecast.ok_or(SelectionError::NoNoise)?;
    Ok(Preview { poses: report.poses, efficiency: report.efficiency, forecast, scale })
}
