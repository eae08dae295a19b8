//! The least-squares problem of a calibration: residuals from full forward kinematics, columns from `J_b`, rows whitened by
//! the noise, tolerances as a prior.

pub(crate) mod belief;
pub(crate) mod calibration_problem;
mod choice;
pub(crate) mod closure_fit;
pub(crate) mod prepared;
pub(crate) mod prior;
pub(crate) mod redundancy;
mod rows;
pub(crate) mod spectrum;
pub(crate) mod start;
pub(crate) mod whitening;
