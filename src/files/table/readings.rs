//! Measured values from the cells of a table.

use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::table::column::Meaning;
use crate::files::table::text_table::Table;
use crate::measurement::{ContactReading, Noise, PoseReading, TargetMeasurement, TargetPoint};

/// Measured poses by row.
pub(crate) fn pose_readings(
    table: &Table,
    machine: &Machine,
    noise: &mut Noise,
) -> Result<Vec<PoseReading>, FileError> {
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

/// Measured targets by row.
pub(crate) fn target_readings(
    table: &Table,
    machine: &Machine,
    noise: &mut Noise,
) -> Result<TargetMeasurement, FileError> {
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

/// Measured heights by row.
pub(crate) fn contact_readings(table: &Table, noise: &mut Noise) -> Result<Vec<ContactReading>, FileError> {
    let mut readings = Vec::with_capacity(table.rows.len());
    let mut every_sigma = true;
    for row in 0..table.rows.len() {
        let mut reading = ContactReading { height: None, sigma: noise.position };
        let mut has_sigma = false;
        for (k, column) in table.columns.iter().enumerate() {
            match column.meaning {
                Meaning::Contact => reading.height = table.number(row, k)?,
                Meaning::SigmaContact => {
                    if let Some(sigma) = positive_sigma(table, row, k)? {
                        reading.sigma = sigma;
                        has_sigma = true;
                    }
                }
                Meaning::Sigma(_) => {
                    return Err(table.cell_error(
                        row,
                        k,
                        "is the sigma of a pose; that of a height is sigma_contact_…",
                    ));
                }
                _ => {}
            }
        }
        every_sigma &= has_sigma || reading.height.is_none();
        readings.push(reading);
    }
    if readings.iter().all(|r| r.height.is_none()) {
        let problem = "no cell of the measured contacts is filled; there is nothing to compare with".into();
        return Err(FileError::Header { path: table.path.clone(), problem });
    }
    noise_from_sigma(table, noise, every_sigma)?;
    Ok(readings)
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
    let stated = table.columns.iter().any(|c| matches!(c.meaning, Meaning::Sigma(_) | Meaning::SigmaContact));
    if stated && !noise.known {
        if !every_sigma {
            let problem = "states sigma for only part of the readings, and the mechanism file has no [noise] for the \
                           rest";
            return Err(FileError::Header { path: table.path.clone(), problem: problem.into() });
        }
        noise.known = true;
    }
    Ok(())
}
