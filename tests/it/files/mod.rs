//! Files that are read and written: units, conditions, effects, kinds, URDF, and texts that are damaged.

mod columns;
mod conditions;
mod documented;
mod effects;
mod homes;
#[cfg(all(feature = "cli", feature = "conformance"))]
mod kinds;
#[cfg(feature = "cli")]
mod readers_never_panic;
#[cfg(feature = "cli")]
mod readings;
mod tables;
mod units_by_dimension;
mod urdf;
#[cfg(feature = "cli")]
mod urdf_never_panics;

use paracal::files::{FileError, Machine, Measurement, read_measurement};

use crate::common::bench::TABLE_5;

/// What a measurement file with this text says of the bundled machine.
fn read_table(text: &str) -> Result<Measurement, FileError> {
    let machine = Machine::from_text(TABLE_5, "m.toml".as_ref()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.csv");
    std::fs::write(&path, text).unwrap();
    read_measurement(&path, &machine)
}
