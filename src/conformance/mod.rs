//! Test suites for implementations of `Mechanism`, `MeasurementModel`, `Identifier`, `ObservabilityIndex`,
//! `PoseSelector` and `Effect` (feature `conformance`).
//!
//! Checks your own implementation with one call in one test:
//!
//! ```no_run
//! # fn check(mechanism: &dyn paracal::mechanism::Mechanism, workspace: &paracal::mechanism::Workspace) {
//! paracal::conformance::mechanism(mechanism, workspace).unwrap();
//! # }
//! ```
//!
//! | suite | checks |
//! |---|---|
//! | [`mechanism()`] | derivatives against differences, kinematics there and back, refusals |
//! | [`measurement()`] | derivatives against differences in any frames, covariances, starts, stated poses and points |
//! | [`identifier()`] | exact data, order of samples, covariance against Monte Carlo, refusals |
//! | [`index()`] | finite values, goal, directions, and that the fast form chooses as brute force does |
//! | [`effect()`] | linearity, columns against forward kinematics, commands there and back |
//! | [`selector()`] | number and feasibility of poses, repeatability on any threads, trace, unusual problems |
//!
//! The laws are those that the rest of the library relies on; a violation names the law, the parameter, joint, row or pose
//! that breaks it, and both numbers. Everything is drawn with a fixed seed, so that a failure repeats.

mod blocks;
mod effect;
mod identifier;
mod index;
mod measurement;
mod mechanism;
mod selector;

pub use effect::effect;
pub use identifier::identifier;
pub use index::index;
pub use measurement::measurement;
pub use mechanism::mechanism;
pub use selector::selector;

use thiserror::Error;

/// A law that does not hold.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{law}: {detail}")]
#[non_exhaustive]
pub struct Violation {
    /// The law.
    pub law: &'static str,
    /// Where it fails, with both numbers.
    pub detail: String,
}

fn violation(law: &'static str, detail: impl Into<String>) -> Violation {
    Violation { law, detail: detail.into() }
}
