//! Mechanism files in TOML: `document` is what a file says, sections as they are written; `read` makes a mechanism of it,
//! with units and places in every error. Each kind, each further section has a file of its own.

pub(crate) mod document;
pub(crate) mod effects;
pub(crate) mod entries;
pub(crate) mod environment;
pub(crate) mod kinds;
pub(crate) mod plane;
pub(crate) mod positioner;
pub(crate) mod read;
