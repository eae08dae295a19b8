//! Measurement files.

use std::path::Path;
use std::sync::Arc;

use crate::conditions::Conditions;
use crate::effect::WithInstrumentEffects;
use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::kinds::pose;
use crate::files::readings::kind::{ReadingKind, Readings};
use crate::files::readings::{KINDS, reading_columns};
use crate::files::table::cells::Cells;
use crate::files::table::column::Meaning;
use crate::files::table::lacking::lacking;
use crate::files::table::spelling::check_spelling;
use crate::files::table::states::States;
use crate::files::table::text_table::Table;
use crate::files::table::unused::{check_sigmas, copies, not_used};
use crate::identification::Estimate;
use crate::measurement::{DataRow, Dataset, Noise, Sample};
use crate::mechanism::{KinematicsError, characteristic_length, height_over_base};
use crate::units::Dimension;

/// A measurement file, read.
#[derive(Debug)]
#[non_exhaustive]
pub struct Measurement {
    /// Samples, readings and noise, seen through the effects of the mechanism file on the measurement
    /// ([`Machine::instrument`]).
    pub data: Dataset,
    /// Warnings for the user.
    pub warnings: Vec<String>,
    /// Names of the columns that neither the model nor its calibration reads; a diagnosis takes those with numbers for
    /// further conditions.
    pub columns_not_used: Vec<String>,
    /// What was measured.
    pub(crate) kind: &'static dyn ReadingKind,
    /// The file as it was read.
    table: Table,
}

impl Measurement {
    /// The same file as a measurement of another machine, such as the calibrated one.
    ///
    /// # Errors
    /// As [`read_measurement`].
    pub fn of(&self, machine: &Machine) -> Result<Self, FileError> {
        let Table { path, columns, rows, warnings } = &self.table;
        let header = columns.iter().map(|c| c.name.clone()).collect();
        measurement_of(path, Cells { header, rows: rows.clone(), warnings: warnings.clone() }, machine)
    }

    /// Puts what was identified with the measurement into the file of the machine: places of targets, the plane. `own` are
    /// the parameters of the data, those of effects on the measurement last.
    pub fn put_identified(&self, machine: &Machine, own: &[Estimate], document: &mut MechanismDocument) {
        let of_effects: usize = machine.instrument().iter().map(|e| e.values.len()).sum();
        self.kind.put_identified(machine, &own[..own.len().saturating_sub(of_effects)], document);
    }
}

/// Reads a measurement file for a machine.
///
/// # Errors
/// [`FileError`] naming row, column and what to do.
pub fn read_measurement(path: impl AsRef<Path>, machine: &Machine) -> Result<Measurement, FileError> {
    let path = path.as_ref();
    measurement_of(path, Cells::read(path)?, machine)
}

/// The measurement that the cells of a file state of a machine.
fn measurement_of(path: &Path, cells: Cells, machine: &Machine) -> Result<Measurement, FileError> {
    let table = Table::of(path, cells, machine, &reading_columns(Some(machine)))?;
    check_spelling(&table, machine)?;
    check_sigmas(&table)?;
    let mut warnings = Vec::new();
    let samples = samples(&table, machine, &mut warnings)?;
    let mut noise = machine.noise.unwrap_or_else(|| Noise::unknown(characteristic_length(machine.mechanism.as_ref())));
    let problem = |problem: String| FileError::Header { path: path.into(), problem };
    let kind = kind_of(&table).map_err(problem)?;
    let Readings { model, every_sigma } = kind.read(&table, machine, &noise)?;
    if (0..model.samples()).all(|k| model.rows(k).is_empty()) {
        let noun = kind.noun().trim_start_matches("a ");
        return Err(problem(format!("no cell of the {noun} is filled; there is nothing to compare with")));
    }
    // Noise that the mechanism file does not state is known if the sigma columns state it for every reading.
    if !noise.known && table.columns.iter().any(|c| states_sigma(&c.meaning)) {
        if !every_sigma {
            let part = "states sigma for only part of the readings, and the mechanism file has no [noise] for the rest";
            return Err(problem(part.into()));
        }
        noise.known = true;
    }
    warnings.extend(lacking(machine, &samples));
    let data = Dataset::new(samples, model, noise);
    // As `refer_to` does for the effects on the machine.
    let environment = Arc::new(machine.environment.with_references_of(&data));
    let data = WithInstrumentEffects::wrap(&data, machine.plain(), &environment, &machine.instrument)
        .map_err(|cause| FileError::Geometry { path: machine.path.clone(), cause })?;
    warnings.extend(copies(&table));
    warnings.extend(on_the_other_side(&data, machine));
    Ok(Measurement { data, warnings, columns_not_used: not_used(&table, machine), kind, table })
}

fn states_sigma(meaning: &Meaning) -> bool {
    matches!(meaning, Meaning::Sigma(_)) || matches!(meaning, Meaning::Reading(c) if c.sigma)
}

/// What there is to say if most poses were measured on that side of the base where the mirror image of home lies.
fn on_the_other_side(data: &Dataset, machine: &Machine) -> Option<String> {
    let note = machine.note_on_home()?;
    let mechanism = machine.plain();
    let at_home = height_over_base(mechanism, &mechanism.home());
    let measured = (0..data.len()).filter_map(|k| {
        let (model, index) = data.reading(k);
        model.rigid_pose(index)
    });
    let other: Vec<bool> = measured.map(|pose| height_over_base(mechanism, &pose) * at_home < 0.0).collect();
    let count = other.iter().filter(|other| **other).count();
    (2 * count > other.len())
        .then(|| format!("{count} of {} measured poses lie on the other side: {note}", other.len()))
}

/// The kind of reading that a table holds.
fn kind_of(table: &Table) -> Result<&'static dyn ReadingKind, String> {
    let measured = |kind: &&dyn ReadingKind| table.columns.iter().any(|c| kind.measures(&c.meaning));
    let mut found = KINDS.into_iter().filter(measured);
    match (found.next(), found.next()) {
        (Some(kind), None) => Ok(kind),
        (Some(kind), Some(other)) => Err(format!("has both {} and {}; keep one of them", kind.noun(), other.noun())),
        (None, _) => {
            let examples: Vec<&str> = KINDS.iter().map(|kind| kind.example()).collect();
            Err(format!("has no measured column; expected {}", examples.join(", or ")))
        }
    }
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
    let pose_space = machine.document.kind == pose::KIND.name;
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
    let sample = |(row, (joints, conditions))| Sample { id: label(row), row: DataRow(row), joints, conditions };
    Ok(commands.into_iter().zip(states).enumerate().map(sample).collect())
}
