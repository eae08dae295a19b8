//! Kinds of readings: their laws, what they determine, and one from outside the crate.

#[cfg(feature = "conformance")]
mod conformance;
mod kinds;
mod own_measurement;
mod plane_contact;
