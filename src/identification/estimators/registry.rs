//! Identifiers by name.

use crate::identification::estimators::identifiers::{Identifier, LeastSquares, LevenbergMarquardt};
use crate::identification::estimators::robust::Robust;

/// Names of the identifiers that [`identifier`] makes.
pub const IDENTIFIERS: &[&str] = &["levenberg-marquardt", "least-squares", "robust"];

/// The identifier of a name, with its default settings.
pub fn identifier(name: &str) -> Option<Box<dyn Identifier>> {
    match name {
        "levenberg-marquardt" => Some(Box::new(LevenbergMarquardt::default())),
        "least-squares" => Some(Box::new(LeastSquares::default())),
        "robust" => Some(Box::new(Robust::default())),
        _ => None,
    }
}
