//! Calibrations against independent data, against Monte Carlo, and from frames far away.

mod deviations;
mod frames;
mod paper_case;
