//! paracal
pub mod conditions;
pub mod mechanism;
pub mod pose;
pub mod solve;
pub mod units;
pub use nalgebra;
