//! `select --for-diagnosis`: how large an effect must be to be seen in the campaign that was chosen.

use std::path::PathBuf;

use crate::conditions::Conditions;
use crate::diagnosis::{DiagnoseError, Question, detection_limits, planned};
use crate::files::{Machine, read_conditions};
use crate::identification::IdentifyError;
use crate::measurement::Noise;
use crate::pose::Pose;
use crate::report::text::CampaignLimits;
use anyhow::{Result, anyhow, bail};

use crate::cli::common::Ui;

/// Options of `select` for a campaign that is to be diagnosed.
#[derive(clap::Args)]
pub(crate) struct DiagnosisArgs {
    /// Also show how large each effect must be for a diagnosis of these poses to detect it; needs [noise].
    #[arg(long)]
    for_diagnosis: bool,
    /// Conditions under which the poses will be measured, one row per pose in the order of the list (fewer rows are
    /// repeated): columns such as temp_leg1_degC, temp_platform_degC, elevation_deg, payload_kg. If absent, a reference
    /// campaign is assumed and described with the result.
    #[arg(long, value_name = "FILE", requires = "for_diagnosis")]
    pub(crate) conditions: Option<PathBuf>,
}

/// What is known of a campaign before its poses are.
pub(crate) struct PlannedCampaign {
    noise: Noise,
    /// Of a file; the reference campaign if absent.
    states: Option<Vec<Conditions>>,
}

impl DiagnosisArgs {
    /// Reads what a campaign needs; `None` if nobody asked.
    pub(crate) fn campaign(&self, machine: &Machine, ui: &Ui) -> Result<Option<PlannedCampaign>> {
        if !self.for_diagnosis {
            return Ok(None);
        }
        let Some(noise) = machine.noise else {
            let file = machine.path.display();
            bail!(
                "{file}: --for-diagnosis: detection limits are multiples of the noise; state [noise] position and \
                   rotation"
            );
        };
        let read = self.conditions.as_ref().map(|path| read_conditions(path, machine)).transpose()?;
        let states = read.map(|read| {
            read.warnings.iter().for_each(|w| ui.warn(w));
            read.states
        });
        Ok(Some(PlannedCampaign { noise, states }))
    }

    /// Limits of the campaign with these poses.
    pub(crate) fn limits(
        &self,
        campaign: &PlannedCampaign,
        machine: &Machine,
        poses: &[Pose],
    ) -> Result<CampaignLimits> {
        let n = poses.len();
        let assumed;
        let states = match &campaign.states {
            Some(states) => states,
            None => {
                assumed = machine.reference_conditions(n);
                &assumed
            }
        };
        let file = machine.path.display();
        let at_pose = |k: usize| format!("{file}: --for-diagnosis: pose {} of the list", k + 1);
        let samples =
            machine.planned_samples(poses, states).map_err(|(k, cause)| anyhow!("{}: {cause}", at_pose(k)))?;
        let failed = |error: IdentifyError| match error {
            IdentifyError::Sample { row, cause, .. } => anyhow!("{}: {cause}", at_pose(row.0)),
            other => anyhow!("{file}: --for-diagnosis: {other}"),
        };
        let data = planned(machine.plain(), samples, machine.convention, campaign.noise, [true; 6]).map_err(failed)?;
        let found = detection_limits(&Question::of(machine, &data));
        let (limits, missing) = found.map_err(|error| match error {
            DiagnoseError::Identify(cause) => failed(cause),
            other => anyhow!("{file}: --for-diagnosis: {other}"),
        })?;
        let conditions = match (&self.conditions, states.len()) {
            (None, _) => {
                format!("assumed (--conditions FILE states your own): {}", machine.reference_conditions_in_words())
            }
            (Some(path), rows) if rows < n => format!(
                "conditions from {}, whose {rows} rows are \
                                                       repeated",
                path.display()
            ),
            (Some(path), _) => format!("conditions from {}", path.display()),
        };
        Ok(CampaignLimits { poses: n, noise: campaign.noise, conditions, limits, missing })
    }
}
