//! From names to an answer: sizes with uncertainties, rivals, gains on rows that were not fitted, limits of what was not
//! found.

pub(crate) mod causes;
pub(crate) mod evidence;
pub(crate) mod findings;
pub(crate) mod gain;
pub(crate) mod limits;
pub(crate) mod not_excluded;
pub(crate) mod result;
pub(crate) mod rivals;
pub(crate) mod unknown;
