//! Presentation of results for people and programs; nothing is computed here.
//!
//! [`text`] makes tables for a terminal of 80 columns, [`json`] the objects whose keys scripts rely on, [`chart`]
//! pictures as SVG, [`html`] pages.

pub mod chart;
pub mod html;
pub mod json;
pub mod text;
