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
