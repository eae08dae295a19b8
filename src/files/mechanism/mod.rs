//! TODO

pub(crate) mod document;
pub(crate) mod effects;
pub(crate) mod entries;
pub(crate) mod environment;
pub(crate) mod kinds;
pub(crate) mod plane;
pub(crate) mod positioner;
pub(crate) mod read;
