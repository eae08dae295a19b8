//! Mechanism files in TOML: `document` and `sections` are what a file says, as it is written, and `toml_text` its text.
//! `read` makes a mechanism of it, with units and places in every error, and `write` the document of another state of it.
//! `kinds` is the table of the kinds of mechanism; each kind and each further section has a file of its own. `examples` are
//! files to start from.

pub(crate) mod calibration;
pub(crate) mod document;
pub(crate) mod effects;
pub(crate) mod environment;
pub(crate) mod examples;
pub(crate) mod joint_names;
pub(crate) mod kinds;
pub(crate) mod plane;
pub(crate) mod read;
pub(crate) mod reader;
pub(crate) mod sections;
pub(crate) mod toml_text;
pub(crate) mod units;
pub(crate) mod write;
