//! TODO

pub(crate) mod calibration_problem;
pub(crate) mod prior;
pub(crate) mod redundancy;
pub(crate) mod whitening;
