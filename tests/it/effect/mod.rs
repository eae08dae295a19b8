//! What each effect does to a mechanism and to readings; effects, conditions and wrappers from outside the crate.

mod instrument;
mod own_condition;
#[cfg(feature = "conformance")]
mod own_effect;
mod truth;
mod wrapped;
