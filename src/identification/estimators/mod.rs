//! Implementations of the trait [`Identifier`](identifiers::Identifier), and what they return.

pub(crate) mod fit;
pub(crate) mod identification;
pub(crate) mod identifiers;
pub(crate) mod registry;
pub(crate) mod robust;
