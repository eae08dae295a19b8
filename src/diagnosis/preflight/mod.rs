//! TODO

pub(crate) mod assignment;
pub(crate) mod compare;
pub(crate) mod misreadings;
