//! Measured positions of points on the platform.

use std::sync::Arc;

use nalgebra::Vector3;
use rand::rngs::ChaCha8Rng;

use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::sections::TargetEntry;
use crate::files::readings::kind::{ReadingKind, Readings, positive_sigma};
use crate::files::table::column::{Meaning, ReadingColumn, target};
use crate::files::table::text_table::Table;
use crate::files::table::writer::{CsvTable, number};
use crate::identification::Estimate;
use crate::measurement::{Noise, TargetMeasurement, TargetPoint};
use crate::simulation::{SimulatedSample, normal};
use crate::units::Dimension;

/// Three coordinates of each target; `[[target]]` of the mechanism file states where they are on the platform.
#[derive(Debug)]
pub(crate) struct TargetsKind;

const AXES: [&str; 3] = ["x", "y", "z"];

impl ReadingKind for TargetsKind {
    fn name(&self) -> &'static str {
        "targets"
    }

    fn noun(&self) -> &'static str {
        "measured targets"
    }

    fn example(&self) -> &'static str {
        "p1x_mm p1y_mm p1z_mm …"
    }

    fn column(&self, name: &str, machine: Option<&Machine>) -> Option<(ReadingColumn, Dimension)> {
        let stated: Vec<String> = machine.iter().flat_map(|m| &m.targets).map(|t| t.name.clone()).collect();
        let of = |name: &str, sigma: bool| {
            let (quantity, axis) = target(name, &stated)?;
            Some((ReadingColumn { kind: self.name(), quantity, axis, sigma }, Dimension::Length))
        };
        of(name, false).or_else(|| of(name.strip_prefix("sigma_")?, true))
    }

    fn read(&self, table: &Table, machine: &Machine, noise: &Noise) -> Result<Readings, FileError> {
        let targets = measured(table, machine);
        let mut readings = Vec::with_capacity(table.rows.len());
        let mut sigmas = Vec::with_capacity(table.rows.len());
        let mut every_sigma = true;
        for row in 0..table.rows.len() {
            let mut cells = vec![[None; 3]; targets.len()];
            let mut sigma = vec![[None; 3]; targets.len()];
            for (k, column) in table.columns.iter().enumerate() {
                let Meaning::Reading(c) = &column.meaning else { continue };
                let Some(t) = targets.iter().position(|t| t.name == c.quantity) else { continue };
                match c.sigma {
                    true => sigma[t][c.axis] = positive_sigma(table, row, k)?,
                    false => cells[t][c.axis] = table.number(row, k)?,
                }
            }
            let of_all = sigma_of_all(table, row)?;
            let stated = |t: usize, k: usize| sigma[t][k].or(of_all[k]);
            let each = (0..targets.len()).flat_map(|t| [0, 1, 2].map(|k| (t, k)));
            every_sigma &= each.into_iter().all(|(t, k)| cells[t][k].is_none() || stated(t, k).is_some());
            let of_target = |t: usize| [0, 1, 2].map(|k| stated(t, k).unwrap_or(noise.position));
            sigmas.push((0..targets.len()).map(of_target).collect());
            readings.push(cells);
        }
        Ok(Readings { model: Arc::new(TargetMeasurement::with_sigma_of_each(targets, readings, sigmas)), every_sigma })
    }

    fn put_identified(&self, machine: &Machine, own: &[Estimate], document: &mut MechanismDocument) {
        for place in own.chunks_exact(3) {
            let name = place[0].spec.name.strip_suffix(AXES[0]).unwrap_or(&place[0].spec.name);
            let platform = Some([0, 1, 2].map(|k| machine.length_unit.from_si(place[k].value)));
            match document.targets.iter_mut().find(|t| t.name == name) {
                Some(entry) => entry.platform = platform,
                None => document.targets.push(TargetEntry { name: name.into(), platform }),
            }
        }
    }

    fn simulate(
        &self,
        machine: &Machine,
        run: &[SimulatedSample],
        noise: &Noise,
        rng: &mut ChaCha8Rng,
    ) -> Result<CsvTable, FileError> {
        let missing = |place: String, problem: &str| FileError::Value {
            path: machine.path.clone(),
            place,
            problem: problem.into(),
        };
        if machine.targets.is_empty() {
            let problem = "there is none; state the name of each target and its place on the platform";
            return Err(missing("[[target]]".into(), problem));
        }
        let unknown = |t: &TargetPoint| {
            missing(format!("[[target]] '{}'", t.name), "has no place; state `platform`, where it is measured")
        };
        let place = |t: &TargetPoint| t.platform.ok_or_else(|| unknown(t));
        let places: Vec<Vector3<f64>> = machine.targets.iter().map(place).collect::<Result<_, _>>()?;
        let unit = machine.length_unit;
        let mut row = |s: &SimulatedSample| {
            let points = places.iter().map(|p| s.seen.place(p));
            let coordinates: Vec<f64> = points.flat_map(<[f64; 3]>::from).collect();
            coordinates.into_iter().map(|v| number(unit.from_si(v + normal(rng, noise.position)))).collect()
        };
        let header = |t: &TargetPoint| AXES.map(|axis| format!("{}{axis}_{}", t.name, unit.name));
        Ok(CsvTable {
            comments: Vec::new(),
            header: machine.targets.iter().flat_map(header).collect(),
            rows: run.iter().map(&mut row).collect(),
        })
    }
}

/// 1σ of a row along each axis, of all targets that state none of their own.
fn sigma_of_all(table: &Table, row: usize) -> Result<[Option<f64>; 3], FileError> {
    let mut sigma = [None; 3];
    for (k, column) in table.columns.iter().enumerate() {
        let Meaning::Sigma(axis) = column.meaning else { continue };
        if axis >= 3 {
            return Err(table.cell_error(row, k, "is the sigma of an angle; targets have positions only"));
        }
        sigma[axis] = positive_sigma(table, row, k)?;
    }
    Ok(sigma)
}

/// The targets in the order of their columns, with the places that the mechanism file states.
fn measured(table: &Table, machine: &Machine) -> Vec<TargetPoint> {
    let mut targets: Vec<TargetPoint> = Vec::new();
    for column in &table.columns {
        if let Meaning::Reading(c) = &column.meaning
            && !c.sigma
            && targets.iter().all(|t| t.name != c.quantity)
        {
            let known = machine.targets.iter().find(|t| t.name == c.quantity);
            targets.push(TargetPoint { name: c.quantity.clone(), platform: known.and_then(|t| t.platform) });
        }
    }
    targets
}
