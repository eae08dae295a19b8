//! TODO

pub(crate) mod design;
pub(crate) mod scenarios;
pub(crate) mod settle;
