//! Chosen sets: the paper, brute force, bounds, and what a set is worth in calibrations.

#[cfg(feature = "conformance")]
mod conformance;
mod gain;
mod long_lists;
mod paper;
mod picks;
mod quality;
mod steep;
