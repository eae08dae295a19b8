//! Measurement files.

use std::path::Path;
use std::sync::Arc;

use super::column::Meaning;
use super::error::FileError;
use super::machine::Machine;
use super::table::Table;
use super::time::parse_time;
use crate::conditions::Conditions;
use crate::measurement::{
    Dataset, MeasurementModel, Noise, PoseMeasurement, PoseReading, Sample, TargetMeasurement, TargetPoint,
};
use crate::mechanism::{KinematicsError, characteristic_length};

/// A measurement file, read.
#[derive(Debug)]
pub struct Measurement {
    /// Samples, readings and noise.
    pub data: Dataset,
    /// The targets, if points were measured.
    pub targets: Option<Arc<TargetMeasurement>>,
    /// What the user should know.
    pub warnings: Vec<String>,
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
    let problem = |problem: &str| FileError::Header { path: path.into(), problem: problem.into() };
    let mut measured_targets = None;
    let model: Arc<dyn MeasurementModel> = match (poses, targets) {
        (true, true) => return Err(problem("has both a measured pose and measured targets; keep one of them")),
        (false, false) => {
            return Err(problem("has no measured column; expected x_mm … rz_deg, or p1x_mm p1y_mm p1z_mm …"));
        }
        (true, false) => {
            let readings = pose_readings(&table, machine, &mut noise)?;
            if readings.iter().all(|r| !r.measured.contains(&true)) {
                return Err(problem("no cell of the measured pose is filled; there is nothing to compare with"));
            }
            Arc::new(PoseMeasurement::new(machine.convention, readings))
        }
        (false, true) => {
            let targets = Arc::new(target_readings(&table, machine, &mut noise)?);
            measured_targets = Some(Arc::clone(&targets));
            targets
        }
    };
    Ok(Measurement { data: Dataset::new(samples, model, noise), targets: measured_targets, warnings })
}

/// Labels, joints and operating states.
fn samples(table: &Table, machine: &Machine, warnings: &mut Vec<String>) -> Result<Vec<Sample>, FileError> {
    let mechanism = machine.mechanism.as_ref();
    let at = Conditions::unknown();
    let find = |meaning: Meaning| table.columns.iter().position(|c| c.meaning == meaning);
    let joints: Vec<Option<usize>> = (0..mechanism.joints().len()).map(|k| find(Meaning::Joint(k))).collect();
    let commanded: Vec<Option<usize>> = (0..6).map(|k| find(Meaning::Commanded(k))).collect();
    let missing: Vec<&str> =
        mechanism.joints().iter().zip(&joints).filter(|(_, c)| c.is_none()).map(|(j, _)| j.name.as_str()).collect();
    let header = |problem: String| FileError::Header { path: table.path.clone(), problem };
    let from_pose = commanded.iter().any(Option::is_some) && missing.len() == joints.len();
    if !missing.is_empty() && !from_pose {
        let unit = machine.length_unit.name;
        return Err(header(format!(
            "no column for {}; commanded lengths stand in columns such as '{}_{unit}', or a commanded pose in cmd_x_{unit} …",
            missing.join(", "),
            missing[0],
        )));
    }
    let ignored = ignored_columns(table);
    if !ignored.is_empty() {
        let names: Vec<&str> = ignored.iter().map(|k| table.columns[*k].name.as_str()).collect();
        warnings.push(format!("columns without numbers are not used: {}", names.join(", ")));
    }
    let id = find(Meaning::Id);
    let home = mechanism.inverse(mechanism.values(), &mechanism.home(), &at).ok();
    let mut samples: Vec<Sample> = Vec::with_capacity(table.rows.len());
    let mut first_time = None;
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
            joints.iter().flatten().map(|column| table.required(row, *column)).collect::<Result<_, _>>()?
        };
        let mut conditions = Conditions::unknown();
        conditions.previous_joints = samples.last().map(|s| s.joints.clone()).or_else(|| home.clone());
        for (k, column) in table.columns.iter().enumerate() {
            match &column.meaning {
                Meaning::Covariate(name) if !ignored.contains(&k) => {
                    if let Some(value) = table.number(row, k)? {
                        let (name, value) = covariate(name, value);
                        conditions.covariates.insert(name, value);
                    }
                }
                Meaning::Clock => {
                    let text = &table.rows[row].1[k];
                    if text.is_empty() {
                        continue;
                    }
                    let advice = "is not a time; write 2026-03-01T12:30:00 or 12:30:00";
                    let time = parse_time(text).ok_or_else(|| table.cell_error(row, k, advice))?;
                    let since = time - *first_time.get_or_insert(time);
                    conditions.covariates.entry("time".into()).or_insert(since);
                }
                _ => {}
            }
        }
        let label = id.map(|k| table.rows[row].1[k].clone()).filter(|t| !t.is_empty());
        samples.push(Sample { id: label, row, joints: values, conditions });
    }
    Ok(samples)
}

/// Elevation stands for zenith distance, so that the two mean one covariate.
fn covariate(name: &str, value: f64) -> (String, f64) {
    match name {
        "zenith_distance" => ("elevation".into(), std::f64::consts::FRAC_PI_2 - value),
        _ => (name.into(), value),
    }
}

/// Columns of no known meaning that hold no number at all, such as remarks.
fn ignored_columns(table: &Table) -> Vec<usize> {
    let text_only = |k: usize| {
        matches!(table.columns[k].meaning, Meaning::Covariate(_))
            && table.columns[k].unit.is_none()
            && table.rows.iter().all(|(_, cells)| cells[k].parse::<f64>().is_err())
    };
    (0..table.columns.len()).filter(|k| text_only(*k)).collect()
}

fn pose_readings(table: &Table, machine: &Machine, noise: &mut Noise) -> Result<Vec<PoseReading>, FileError> {
    let quaternion = table.quaternion_columns()?;
    let mut every_sigma = true;
    let mut readings = Vec::with_capacity(table.rows.len());
    for row in 0..table.rows.len() {
        let (p, r) = (noise.position, noise.rotation);
        let mut reading = PoseReading { values: [0.0; 6], measured: [false; 6], sigma: [p, p, p, r, r, r] };
        let mut has_sigma = [false; 6];
        for (column, c) in table.columns.iter().enumerate() {
            match c.meaning {
                Meaning::Pose(k) => {
                    if let Some(value) = table.number(row, column)? {
                        reading.values[k] = value;
                        reading.measured[k] = true;
                    }
                }
                Meaning::Sigma(k) => {
                    if let Some(sigma) = positive_sigma(table, row, column)? {
                        reading.sigma[k] = sigma;
                        has_sigma[k] = true;
                    }
                }
                _ => {}
            }
        }
        if let Some(turn) = quaternion.map(|columns| table.quaternion(row, &columns)).transpose()?.flatten() {
            reading.values[3..].copy_from_slice(machine.convention.angles(&turn.to_rotation_matrix()).as_slice());
            reading.measured[3..].fill(true);
        }
        every_sigma &= (0..6).all(|k| has_sigma[k] || !reading.measured[k]);
        readings.push(reading);
    }
    noise_from_sigma(table, noise, every_sigma)?;
    Ok(readings)
}

fn target_readings(table: &Table, machine: &Machine, noise: &mut Noise) -> Result<TargetMeasurement, FileError> {
    let mut targets: Vec<TargetPoint> = Vec::new();
    for column in &table.columns {
        if let Meaning::Target(name, _) = &column.meaning
            && targets.iter().all(|t| t.name != *name)
        {
            let known = machine.targets.iter().find(|t| t.name == *name);
            targets.push(TargetPoint { name: name.clone(), platform: known.and_then(|t| t.platform) });
        }
    }
    let mut readings = Vec::with_capacity(table.rows.len());
    let mut sigmas = Vec::with_capacity(table.rows.len());
    let mut every_sigma = true;
    for row in 0..table.rows.len() {
        let mut cells = vec![[None; 3]; targets.len()];
        for (k, column) in table.columns.iter().enumerate() {
            if let Meaning::Target(name, axis) = &column.meaning
                && let Some(t) = targets.iter().position(|t| t.name == *name)
            {
                cells[t][*axis] = table.number(row, k)?;
            }
        }
        let (mut sigma, mut has_sigma) = ([noise.position; 3], [false; 3]);
        for (k, column) in table.columns.iter().enumerate() {
            let Meaning::Sigma(axis) = column.meaning else { continue };
            if axis >= 3 {
                return Err(table.cell_error(row, k, "is the sigma of an angle; targets have positions only"));
            }
            if let Some(s) = positive_sigma(table, row, k)? {
                sigma[axis] = s;
                has_sigma[axis] = true;
            }
        }
        every_sigma &= has_sigma == [true; 3];
        sigmas.push(sigma);
        readings.push(cells);
    }
    if readings.iter().flatten().flatten().all(Option::is_none) {
        let problem = "no cell of the measured targets is filled; there is nothing to compare with".into();
        return Err(FileError::Header { path: table.path.clone(), problem });
    }
    noise_from_sigma(table, noise, every_sigma)?;
    Ok(TargetMeasurement::new(targets, readings, sigmas))
}

/// 1σ in a cell; `None` if it is empty.
fn positive_sigma(table: &Table, row: usize, column: usize) -> Result<Option<f64>, FileError> {
    let sigma = table.number(row, column)?;
    if sigma.is_some_and(|s| s <= 0.0) {
        let advice = "must be positive; leave the cell empty if it is not known";
        return Err(table.cell_error(row, column, advice));
    }
    Ok(sigma)
}

/// Noise that the mechanism file does not state is known if the sigma columns state it for every reading.
fn noise_from_sigma(table: &Table, noise: &mut Noise, every_sigma: bool) -> Result<(), FileError> {
    let stated = table.columns.iter().any(|c| matches!(c.meaning, Meaning::Sigma(_)));
    if stated && !noise.known {
        if !every_sigma {
            let problem = "states sigma for a part of the readings, and the mechanism file has no [noise] for the rest";
            return Err(FileError::Header { path: table.path.clone(), problem: problem.into() });
        }
        noise.known = true;
    }
    Ok(())
}
