//! What each effect does to a mechanism and to readings, and effects from outside the crate.

#[cfg(feature = "conformance")]
mod own_effect;
mod truth;
