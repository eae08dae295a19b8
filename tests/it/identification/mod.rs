//! Calibrations against independent data, against Monte Carlo, and from frames far away.

mod deviations;
mod drawing;
mod frames;
mod gross_errors;
mod paper_case;
mod starts;
mod work;
