//! TODO

pub(crate) mod identification;
pub(crate) mod identifiers;
pub(crate) mod robust;
