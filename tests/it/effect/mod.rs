//! What each effect does to a mechanism and to readings; effects and wrappers from outside the crate.

#[cfg(feature = "conformance")]
mod own_effect;
mod truth;
mod wrapped;
