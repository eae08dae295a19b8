//! Results as a page that people look at: one self-contained file, without scripts and without anything from elsewhere.
//!
//! A [`Page`] begins with the verdict in one sentence and what to do, then shows pictures and tables, and ends with what
//! repeats it. It reads on a dark screen, on a telephone and on paper. [`calibration`], [`diagnosis`] and [`evaluation`]
//! make the pages of these commands.

mod calibration;
mod diagnosis;
mod evaluation;
mod page;
mod residuals;

pub use calibration::calibration;
pub use diagnosis::diagnosis;
pub use evaluation::evaluation;
pub(crate) use page::shell;
pub use page::{Page, Part, Section, Tone};
