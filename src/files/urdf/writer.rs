//! Placeholder.
/// Placeholder.
#[derive(Debug)]
pub struct UrdfFiles {}
