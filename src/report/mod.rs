//! Presentation of results for people and programs; nothing is computed here.
//!
//! [`text`] makes tables for a terminal of 80 columns, [`json`] the objects whose keys scripts rely on, [`html`] pages.
//! Charts are drawn for these pages and for the pictures of the documentation; they may change with any version.

#[doc(hidden)]
pub mod chart;
pub mod html;
mod in_the_drawing;
pub mod json;
pub mod text;
