//! Measured heights over a plane.

use std::sync::Arc;

use rand::rngs::ChaCha8Rng;

use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::readings::kind::{ReadingKind, Readings, positive_sigma};
use crate::files::table::column::{Meaning, ReadingColumn};
use crate::files::table::text_table::Table;
use crate::files::table::writer::{CsvTable, number};
use crate::identification::Estimate;
use crate::measurement::{ContactReading, Noise, PlaneContact};
use crate::simulation::{SimulatedSample, normal};
use crate::units::Dimension;

/// The height of the tip over the plane; `[plane]` of the mechanism file states both.
#[derive(Debug)]
pub(crate) struct ContactKind;

impl ReadingKind for ContactKind {
    fn name(&self) -> &'static str {
        "contact"
    }

    fn noun(&self) -> &'static str {
        "measured contacts"
    }

    fn example(&self) -> &'static str {
        "contact_mm"
    }

    fn column(&self, name: &str, _machine: Option<&Machine>) -> Option<(ReadingColumn, Dimension)> {
        let sigma = name == "sigma_contact";
        let column = ReadingColumn { kind: self.name(), quantity: "contact".into(), axis: 0, sigma };
        (sigma || name == "contact").then_some((column, Dimension::Length))
    }

    fn read(&self, table: &Table, machine: &Machine, noise: &Noise) -> Result<Readings, FileError> {
        let mut readings = Vec::with_capacity(table.rows.len());
        let mut every_sigma = true;
        for row in 0..table.rows.len() {
            let mut reading = ContactReading { height: None, sigma: noise.position };
            let mut has_sigma = false;
            for (k, column) in table.columns.iter().enumerate() {
                match &column.meaning {
                    Meaning::Reading(c) if c.sigma => {
                        if let Some(sigma) = positive_sigma(table, row, k)? {
                            reading.sigma = sigma;
                            has_sigma = true;
                        }
                    }
                    Meaning::Reading(_) => reading.height = table.number(row, k)?,
                    Meaning::Sigma(_) => {
                        let problem = "is the sigma of a pose; that of a height is sigma_contact_…";
                        return Err(table.cell_error(row, k, problem));
                    }
                    _ => {}
                }
            }
            every_sigma &= has_sigma || reading.height.is_none();
            readings.push(reading);
        }
        Ok(Readings { model: Arc::new(PlaneContact::new(machine.contact, readings)), every_sigma })
    }

    fn put_identified(&self, machine: &Machine, own: &[Estimate], document: &mut MechanismDocument) {
        if machine.contact.known {
            return;
        }
        let own: Vec<f64> = own.iter().map(|p| p.value).collect();
        // The plane follows from its parameters alone, without any reading.
        let located = PlaneContact::new(machine.contact, Vec::new()).located(&own);
        document.plane = Some(machine.plane_section(&located));
    }

    fn simulate(
        &self,
        machine: &Machine,
        run: &[SimulatedSample],
        noise: &Noise,
        rng: &mut ChaCha8Rng,
    ) -> Result<CsvTable, FileError> {
        let (contact, unit) = (&machine.contact, machine.length_unit);
        let mut height = |s: &SimulatedSample| {
            let seen = contact.plane.height(&s.seen.place(&contact.tip));
            vec![number(unit.from_si(seen + normal(rng, noise.position)))]
        };
        Ok(CsvTable {
            comments: Vec::new(),
            header: vec![format!("contact_{}", unit.name)],
            rows: run.iter().map(&mut height).collect(),
        })
    }

    fn advice_on_frames(&self) -> &'static str {
        "check the [plane] of the mechanism file, or state identify = true there"
    }
}
