//! Measured poses, whole or in part.

use std::sync::Arc;

use rand::rngs::ChaCha8Rng;

use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::readings::kind::{ReadingKind, Readings, positive_sigma};
use crate::files::table::column::{Meaning, POSE_NAMES, ReadingColumn};
use crate::files::table::text_table::Table;
use crate::files::table::writer::{CsvTable, number};
use crate::measurement::{Noise, PoseMeasurement, PoseReading};
use crate::simulation::SimulatedSample;
use crate::units::{Dimension, show_angle, show_length};

/// Six coordinates of the pose, or some of them. Its columns are those of lists of poses.
#[derive(Debug)]
pub(crate) struct PoseKind;

impl ReadingKind for PoseKind {
    fn name(&self) -> &'static str {
        "pose"
    }

    fn noun(&self) -> &'static str {
        "a measured pose"
    }

    fn example(&self) -> &'static str {
        "x_mm … rz_deg"
    }

    fn column(&self, _name: &str, _machine: Option<&Machine>) -> Option<(ReadingColumn, Dimension)> {
        None
    }

    fn measures(&self, meaning: &Meaning) -> bool {
        matches!(meaning, Meaning::Pose(_) | Meaning::Quaternion(_))
    }

    fn read(&self, table: &Table, machine: &Machine, noise: &Noise) -> Result<Readings, FileError> {
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
        Ok(Readings { model: Arc::new(PoseMeasurement::new(machine.convention, readings)), every_sigma })
    }

    fn simulate(
        &self,
        machine: &Machine,
        run: &[SimulatedSample],
        _noise: &Noise,
        _rng: &mut ChaCha8Rng,
    ) -> Result<CsvTable, FileError> {
        // The noise is in the coordinates already.
        Ok(pose_columns(machine, run.iter().map(|s| &s.measured)))
    }

    fn shown_noise(&self, noise: &Noise) -> String {
        format!("{} and {}", show_length(noise.position), show_angle(noise.rotation))
    }
}

/// Columns of poses, from coordinates (m and rad) of the machine's convention.
pub(crate) fn pose_columns<'a>(machine: &Machine, poses: impl Iterator<Item = &'a [f64; 6]>) -> CsvTable {
    let unit = |k: usize| if k < 3 { machine.length_unit } else { machine.angle_unit };
    CsvTable {
        comments: Vec::new(),
        header: POSE_NAMES.iter().enumerate().map(|(k, name)| format!("{name}_{}", unit(k).name)).collect(),
        rows: poses.map(|q| (0..6).map(|k| number(unit(k).from_si(q[k]))).collect()).collect(),
    }
}
