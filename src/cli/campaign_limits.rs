//! `select --for-diagnosis`: how large an effect must be to be seen in the campaign that was chosen.

use std::path::PathBuf;

use crate::diagnosis::{DiagnoseError, Question, detection_limits, planned};
use crate::files::{CsvTable, Machine, PlannedConditions, read_conditions};
use crate::identification::IdentifyError;
use crate::measurement::Noise;
use crate::pose::Pose;
use crate::report::text::CampaignLimits;
use anyhow::{Result, anyhow, bail};

use crate::cli::ui::Ui;

/// Options of `select` for a campaign that is to be diagnosed.
#[derive(clap::Args)]
pub(crate) struct DiagnosisArgs {
    /// Also show how large each effect must be for a diagnosis of these poses to detect it; needs [noise].
    #[arg(long)]
    for_diagnosis: bool,
    /// Conditions under which the poses will be measured, one row per pose in the order of the list (fewer rows are
    /// repeated): columns such as temp_leg1_degC, temp_platform_degC, elevation_deg, payload_kg. They are written into
    /// the list. If absent, --for-diagnosis assumes a reference campaign and describes it with the result.
    #[arg(long, value_name = "FILE")]
    pub(crate) conditions: Option<PathBuf>,
}

/// What is known of a campaign before its poses are.
pub(crate) struct PlannedCampaign {
    /// Noise of the campaign, if limits are asked for.
    noise: Option<Noise>,
    /// Of a file; the reference campaign if absent.
    conditions: Option<PlannedConditions>,
}

impl PlannedCampaign {
    /// The columns of the conditions, if a file states them.
    pub(crate) fn columns(&self) -> Option<&CsvTable> {
        self.conditions.as_ref().map(|planned| &planned.columns)
    }
}

impl DiagnosisArgs {
    /// Reads what is known of the campaign.
    pub(crate) fn campaign(&self, machine: &Machine, ui: &Ui) -> Result<PlannedCampaign> {
        if self.for_diagnosis && machine.noise.is_none() {
            let file = machine.path.display();
            bail!(
                "{file}: --for-diagnosis: detection limits are multiples of the noise; state [noise] position and \
                   rotation"
            );
        }
        let conditions = self.conditions.as_ref().map(|path| read_conditions(path, machine)).transpose()?;
        conditions.iter().flat_map(|read| &read.warnings).for_each(|w| ui.warn(w));
        Ok(PlannedCampaign { noise: machine.noise.filter(|_| self.for_diagnosis), conditions })
    }

    /// Limits of the campaign with these poses; `None` if nobody asked.
    pub(crate) fn limits(
        &self,
        campaign: &PlannedCampaign,
        machine: &Machine,
        poses: &[Pose],
    ) -> Result<Option<CampaignLimits>> {
        let Some(noise) = campaign.noise else { return Ok(None) };
        let n = poses.len();
        let assumed;
        let states = match &campaign.conditions {
            Some(read) => &read.states,
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
        let data = planned(machine.plain(), samples, machine.convention, noise, [true; 6]).map_err(failed)?;
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
        Ok(Some(CampaignLimits { poses: n, noise, conditions, limits, missing }))
    }
}
