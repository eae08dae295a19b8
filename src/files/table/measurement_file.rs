//! Measurement files.

use std::path::Path;
use std::sync::Arc;

use crate::conditions::Conditions;
use crate::effect::{ActiveEffect, WithInstrumentEffects};
use crate::files::error::FileError;
use crate::files::machine::{Machine, POSE};
use crate::files::table::column::Meaning;
use crate::files::table::readings::{contact_readings, pose_readings, target_readings};
use crate::files::table::states::States;
use crate::files::table::text_table::Table;
use crate::measurement::{Dataset, MeasurementModel, Noise, PlaneContact, PoseMeasurement, Sample, TargetMeasurement};
use crate::mechanism::{KinematicsError, characteristic_length};
use crate::units::Dimension;

/// A measurement file, read.
#[derive(Debug)]
pub struct Measurement {
    /// Samples, readings and noise, seen through the instrument of the mechanism file.
    pub data: Dataset,
    /// The targets, if points were measured.
    pub targets: Option<Arc<TargetMeasurement>>,
    /// The heights over a plane, if they were measured.
    pub contacts: Option<Arc<PlaneContact>>,
    /// The data without the effects of the mechanism file on the measurement.
    pub as_read: Dataset,
    /// The effects of the mechanism file through which the readings are seen.
    pub instrument: Vec<ActiveEffect>,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

impl Measurement {
    /// The effects on the measurement with these values of the own parameters of the data.
    pub fn located(&self, own: &[f64]) -> Vec<ActiveEffect> {
        let count = self.instrument.iter().map(|e| e.values.len()).sum();
        ActiveEffect::with_values(&self.instrument, own[own.len().saturating_sub(count)..].iter().copied())
    }
}

/// Reads a measurement file for a machine.
///
/// # Errors
/// [`FileError`] naming row, column and what to do.
pub fn read_measurement(path: impl AsRef<Path>, machine: &Machine) -> Result<Measurement, FileError> {
    let path = path.as_ref();
    let names: Vec<String> = machine.targets.iter().map(|t| t.name.clone()).collect();
    let table = Table::read(path, machine, &names)?;
    let mut warnings = Vec::new();
    let samples = samples(&table, machine, &mut warnings)?;
    let mut noise = machine.noise.unwrap_or_else(|| Noise::unknown(characteristic_length(machine.mechanism.as_ref())));
    let has = |test: fn(&Meaning) -> bool| table.columns.iter().any(|c| test(&c.meaning));
    let poses = has(|m| matches!(m, Meaning::Pose(_) | Meaning::Quaternion(_)));
    let targets = has(|m| matches!(m, Meaning::Target(..)));
    let contacts = has(|m| matches!(m, Meaning::Contact));
    let problem = |problem: &str| FileError::Header { path: path.into(), problem: problem.into() };
    if !contacts && has(|m| matches!(m, Meaning::SigmaContact)) {
        return Err(problem("has sigma_contact_… without a column contact_…; add it or delete the sigma"));
    }
    let (mut measured_targets, mut measured_contacts) = (None, None);
    let model: Arc<dyn MeasurementModel> = match (poses, targets, contacts) {
        (true, true, _) => return Err(problem("has both a measured pose and measured targets; keep one of them")),
        (true, _, true) => return Err(problem("has both a measured pose and measured contacts; keep one of them")),
        (_, true, true) => return Err(problem("has both measured targets and measured contacts; keep one of them")),
        (false, false, false) => {
            return Err(problem(
                "has no measured column; expected x_mm … rz_deg, or p1x_mm p1y_mm p1z_mm …, or contact_mm",
            ));
        }
        (true, ..) => {
            let readings = pose_readings(&table, machine, &mut noise)?;
            if readings.iter().all(|r| !r.measured.contains(&true)) {
                return Err(problem("no cell of the measured pose is filled; there is nothing to compare with"));
            }
            Arc::new(PoseMeasurement::new(machine.convention, readings))
        }
        (_, true, _) => {
            let targets = Arc::new(target_readings(&table, machine, &mut noise)?);
            measured_targets = Some(Arc::clone(&targets));
            targets
        }
        (_, _, true) => {
            let contacts = Arc::new(PlaneContact::new(machine.contact, contact_readings(&table, &mut noise)?));
            measured_contacts = Some(Arc::clone(&contacts));
            contacts
        }
    };
    let as_read = Dataset::new(samples, model, noise);
    let data = WithInstrumentEffects::wrap(&as_read, machine.plain(), &machine.environment, &machine.instrument)
        .map_err(|cause| FileError::Geometry { path: machine.path.clone(), cause })?;
    let instrument = machine.instrument.clone();
    Ok(Measurement { data, as_read, targets: measured_targets, contacts: measured_contacts, instrument, warnings })
}

/// Labels, joints and operating states.
fn samples(table: &Table, machine: &Machine, warnings: &mut Vec<String>) -> Result<Vec<Sample>, FileError> {
    let mechanism = machine.plain();
    let at = Conditions::unknown();
    let find = |meaning: Meaning| table.columns.iter().position(|c| c.meaning == meaning);
    let joints: Vec<Option<usize>> = (0..mechanism.joints().len()).map(|k| find(Meaning::Joint(k))).collect();
    let commanded: Vec<Option<usize>> = (0..6).map(|k| find(Meaning::Commanded(k))).collect();
    let missing: Vec<&str> =
        mechanism.joints().iter().zip(&joints).filter(|(_, c)| c.is_none()).map(|(j, _)| j.name.as_str()).collect();
    let header = |problem: String| FileError::Header { path: table.path.clone(), problem };
    let from_pose = commanded.iter().any(Option::is_some) && missing.len() == joints.len();
    // What was not commanded to a positioner in pose space was commanded to be zero.
    let pose_space = machine.document.kind == POSE;
    if !missing.is_empty() && !from_pose && !pose_space {
        let length = machine.length_unit.name;
        let joint = mechanism.joints().iter().find(|j| j.name == missing[0]).map_or(Dimension::Length, |j| j.dimension);
        let (noun, unit) = (joint.noun(), machine.unit(joint).name);
        return Err(header(format!(
            "no column for {}; give commanded {noun} in columns such as '{}_{unit}', or a commanded pose in \
             cmd_x_{length} …",
            missing.join(", "),
            missing[0],
        )));
    }
    let States { mut states, warnings: found, .. } = States::read(table, machine)?;
    warnings.extend(found);
    let id = find(Meaning::Id);
    let mut commands: Vec<Vec<f64>> = Vec::with_capacity(table.rows.len());
    for row in 0..table.rows.len() {
        let values: Vec<f64> = if from_pose {
            // A coordinate that is not commanded stays at home.
            let commander = machine.commander();
            let mut q = machine.convention.coordinates(&commander.home());
            for (k, column) in commanded.iter().enumerate() {
                if let Some(column) = column {
                    q[k] = table.required(row, *column)?;
                }
            }
            let pose = machine.convention.pose(&q);
            let lengths = commander.inverse(commander.values(), &pose, &at);
            let failed = |cause| FileError::Kinematics { path: table.path.clone(), row, cause };
            let lengths = lengths.map_err(failed)?;
            if lengths.iter().any(|v| !v.is_finite()) {
                return Err(failed(KinematicsError::NotFinite { what: "a length for the commanded pose".into() }));
            }
            lengths
        } else {
            let value = |column: &Option<usize>| column.map_or(Ok(0.0), |column| table.required(row, column));
            joints.iter().map(value).collect::<Result<_, _>>()?
        };
        commands.push(values);
    }
    Conditions::put_in_run(&mut states, commands.clone(), machine.environment.home_joints.as_deref());
    let label = |row: usize| id.map(|k| table.rows[row].1[k].clone()).filter(|t| !t.is_empty());
    let sample = |(row, (joints, conditions))| Sample { id: label(row), row, joints, conditions };
    Ok(commands.into_iter().zip(states).enumerate().map(sample).collect())
}
