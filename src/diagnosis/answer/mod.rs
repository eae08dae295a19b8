//! TODO

pub(crate) mod evidence;
pub(crate) mod findings;
pub(crate) mod gain;
pub(crate) mod limits;
pub(crate) mod result;
