//! What was found of a robot: its legs and its home.

use nalgebra::Vector3;

use crate::pose::Pose;

/// A leg, SI.
#[derive(Clone, Debug)]
pub(super) struct FoundLeg {
    pub(super) joint: String,
    pub(super) reversed: bool,
    pub(super) platform: Vector3<f64>,
    pub(super) base: Vector3<f64>,
    /// Length at joint coordinate zero.
    pub(super) length: f64,
    pub(super) range: Option<[f64; 2]>,
}

/// What a robot is made of, for this program.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub(super) legs: Vec<FoundLeg>,
    /// `None` where neither joints nor lengths say it.
    pub(super) home: Option<Pose>,
}
