//! Mechanisms with known errors, what a tracker would measure of them, and calibrations by the thousand.
//!
//! The generator shares no formula with the identification: it commands the lengths of the *nominal* inverse
//! kinematics, solves the full forward kinematics of the *true* mechanism, and adds noise to the coordinates
//! (section 4.1, steps 1 and 2). The identification works with columns of Jacobians.
//!
//! | part | does |
//! |---|---|
//! | [`simulate`], [`simulate_run`] | one measured campaign of a mechanism with errors |
//! | [`Trial`] | a whole calibration: simulate, identify, and see where the calibrated model leads |
//! | [`monte_carlo`], [`summarise`] | repeat anything with a random stream of its own for each draw |
//! | [`RunningStats`] | mean, spread and extremes of numbers that come one by one |
//!
//! Randomness comes in as a seeded generator. A draw has the stream of its number, and blocks of draws are joined in
//! their order, so that results are the same, to the last bit, on any number of threads.

mod generator;
mod monte_carlo;
mod running_stats;
mod trial;

#[cfg(feature = "files")]
pub(crate) use generator::normal;
pub use generator::{Command, Instrument, SimulatedSample, as_dataset, draw_parameters, simulate, simulate_run};
pub use monte_carlo::{monte_carlo, stream, summarise};
pub use running_stats::RunningStats;
pub use trial::{Estimator, TargetErrors, Trial, TrialError, TrialResult, target_errors};
