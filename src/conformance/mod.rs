//! Test suites for implementations of `Mechanism` and `Identifier` (feature `conformance`).
//!
//! A mechanism or an identifier that was written elsewhere is checked with one call in one test:
//!
//! ```no_run
//! # fn check(mechanism: &dyn paracal::mechanism::Mechanism, workspace: &paracal::mechanism::Workspace) {
//! paracal::conformance::mechanism(mechanism, workspace).unwrap();
//! # }
//! ```
//!
//! The laws are those that the rest of the library relies on; a violation names the law, the parameter or joint
//! by its name, the pose, and both numbers. Poses are drawn with a fixed seed, so that a failure repeats.

mod identifier;
mod mechanism;

pub use identifier::identifier;
pub use mechanism::mechanism;

use thiserror::Error;

/// A law that does not hold.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{law}: {detail}")]
pub struct Violation {
    /// The law.
    pub law: &'static str,
    /// Where it fails, with both numbers.
    pub detail: String,
}

fn violation(law: &'static str, detail: impl Into<String>) -> Violation {
    Violation { law, detail: detail.into() }
}
