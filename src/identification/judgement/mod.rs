//! How far a result can be trusted: misfit, plausibility, directions that the poses do not determine, errors on rows that
//! were not fitted, and predicted errors over the workspace.

pub(crate) mod deviations;
pub(crate) mod drawing;
pub(crate) mod fit_test;
pub(crate) mod goodness_of_fit;
pub(crate) mod held_out;
pub(crate) mod kinds;
pub(crate) mod model_errors;
pub(crate) mod plausibility;
pub(crate) mod prediction;
pub(crate) mod samples;
pub(crate) mod verdict;
pub(crate) mod warnings;
pub(crate) mod weak_directions;
pub(crate) mod worth;
