//! The list that `select` writes: in the order of measuring, with joints that the controller can be told.

use crate::conditions::Conditions;
use crate::files::{CsvTable, JointsAndPose, Machine, joints_and_poses};
use crate::pose::Pose;
use crate::selection::ChosenSet;
use crate::units::{Dimension, parse_quantity};
use anyhow::{Result, anyhow, bail};

/// The joints of a machine rounded to a multiple of `resolution`, and where that leads to.
struct Rounding<'a> {
    machine: &'a Machine,
    /// By joint, SI.
    resolution: Vec<f64>,
}

impl<'a> Rounding<'a> {
    /// Reads a resolution, a length or an angle, for the joints that are of its dimension.
    fn of(text: &str, machine: &'a Machine) -> Result<Self> {
        let joints = machine.mechanism.joints();
        let read = |dimension| parse_quantity(text, dimension).ok().map(|value| (dimension, value));
        let Some((dimension, value)) = read(Dimension::Length).or_else(|| read(Dimension::Angle)) else {
            bail!("--resolution {text}: is neither a length such as 1um nor an angle such as 0.1arcsec");
        };
        if !(value > 0.0) {
            bail!("--resolution {text}: must be positive");
        }
        if joints.iter().all(|j| j.dimension != dimension) {
            let noun = joints.first().map_or("", |j| j.dimension.noun());
            bail!("--resolution {text}: the joints of this mechanism are {noun}");
        }
        let resolution = joints.iter().map(|j| if j.dimension == dimension { value } else { 0.0 }).collect();
        Ok(Self { machine, resolution })
    }

    fn round(&self, joints: &mut [f64], pose: &mut Pose) -> Result<()> {
        for (value, step) in joints.iter_mut().zip(&self.resolution).filter(|(_, step)| **step > 0.0) {
            *value = (*value / step).round() * step;
        }
        let mechanism = self.machine.mechanism.as_ref();
        *pose = mechanism.forward(mechanism.values(), joints, &Conditions::unknown(), pose)?;
        Ok(())
    }
}

/// The rows to measure; the poses of the choice become those of rounded joints.
pub(crate) fn rows(
    machine: &Machine,
    report: &mut ChosenSet,
    given: usize,
    resolution: Option<&str>,
) -> Result<Vec<JointsAndPose>> {
    let rounding = resolution.map(|text| Rounding::of(text, machine)).transpose()?;
    let mechanism = machine.mechanism.as_ref();
    let mut rows = Vec::with_capacity(report.poses.len());
    for (k, pose) in report.poses.iter_mut().enumerate() {
        let mut joints = mechanism.inverse(mechanism.values(), pose, &Conditions::unknown())?;
        if let Some(rounding) = rounding.as_ref().filter(|_| k >= given) {
            let at = |cause: anyhow::Error| anyhow!("--resolution: pose {} of the list: {cause}", k + 1);
            rounding.round(&mut joints, pose).map_err(at)?;
        }
        let label = if k < given { format!("given{}", k + 1) } else { format!("new{}", k + 1 - given) };
        let id = (given > 0).then_some(label);
        rows.push(JointsAndPose { id, joints, pose: machine.convention.coordinates(pose) });
    }
    Ok(rows)
}

/// The list as a table; conditions that are fewer than the poses repeat.
pub(crate) fn table(
    machine: &Machine,
    rows: &[JointsAndPose],
    conditions: Option<&CsvTable>,
    comment: String,
) -> CsvTable {
    let mut table = joints_and_poses(machine, comment, rows);
    if let Some(conditions) = conditions {
        let repeated = conditions.rows.iter().cycle().take(rows.len()).cloned().collect();
        table.append(&CsvTable { rows: repeated, ..conditions.clone() });
    }
    table
}

/// What stands below the list.
pub(crate) fn comment(machine: &Machine, report: &ChosenSet, scaling: &str, selector: &str, seed: u64) -> String {
    format!(
        "{} poses for {}: {} = {:e} ({scaling} scaling), {selector}, seed {seed}",
        report.poses.len(),
        machine.mechanism.name(),
        report.index,
        report.value,
    )
}
