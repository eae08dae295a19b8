//! Options for reading a URDF file.

use crate::units::Dimension;

/// Information that a URDF file lacks, supplied by the caller. The default supplies nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UrdfOptions {
    /// Pairs of links or joints whose frames coincide when the mechanism is assembled.
    pub close: Vec<[String; 2]>,
    /// The link whose frame is the base frame.
    pub base_link: Option<String>,
    /// The link whose frame is the platform frame.
    pub platform_link: Option<String>,
    /// Joint coordinates of the assembled home; zero for joints that are not named.
    pub home: Vec<HomeJoint>,
    /// How far axes may miss their common point and closing frames each other at home, m; 1e-4 of a leg if absent.
    pub tolerance: Option<f64>,
}

/// A joint coordinate at home.
#[derive(Clone, Debug, PartialEq)]
pub struct HomeJoint {
    /// Name of the joint.
    pub joint: String,
    /// Its coordinate, SI.
    pub value: f64,
    /// Dimension of the coordinate, if it was stated with a unit; it must fit the joint.
    pub dimension: Option<Dimension>,
}

impl UrdfOptions {
    /// True if nothing is stated.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
