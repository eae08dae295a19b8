//! paracal
pub mod conditions;
#[cfg(feature = "conformance")]
pub mod conformance;
pub mod files;
pub mod identification;
pub mod measurement;
pub mod mechanism;
pub mod pose;
pub mod report;
pub mod simulation;
pub mod solve;
pub mod units;
pub use nalgebra;
