//! Description of a closure-defined mechanism, apart from its closure.

use crate::mechanism::{Axis, JointSpec, ParameterRole, ParameterSpec};
use crate::pose::Pose;
use crate::units::Dimension;

/// Parameters, joints, home and number of equations of a [`Closure`](super::Closure).
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Display name of the mechanism.
    pub name: String,
    /// Number of closure equations, passive ones included: at least six more than passive coordinates.
    pub equations: usize,
    /// Parameters in the order in which the closure reads them.
    pub parameters: Vec<ParameterSpec>,
    /// Joints in the order in which the closure reads them.
    pub joints: Vec<JointSpec>,
    /// Pose from which forward kinematics starts.
    pub home: Pose,
    /// Joint coordinates near home: the branch of inverse kinematics.
    pub home_joints: Vec<f64>,
    /// Start of the passive coordinates; empty if there are none.
    pub passive: Vec<f64>,
    /// Which of x, y, z, α, β, γ the joints control; the others follow from the closure.
    pub controlled: [bool; 6],
}

impl Outline {
    /// A mechanism of six degrees of freedom with `equations` closure equations, so far without joints and parameters.
    pub fn new(name: impl Into<String>, equations: usize, home: Pose) -> Self {
        Self {
            name: name.into(),
            equations,
            parameters: Vec::new(),
            joints: Vec::new(),
            home,
            home_joints: Vec::new(),
            passive: Vec::new(),
            controlled: [true; 6],
        }
    }

    /// Adds a joint by the name of its data columns, with its coordinate near home and its stroke, SI. Those of the built-in
    /// kinds are called `leg1`, `leg2` ….
    #[must_use]
    pub fn joint(
        mut self,
        name: impl Into<String>,
        dimension: Dimension,
        near_home: f64,
        stroke: Option<[f64; 2]>,
    ) -> Self {
        self.joints.push(JointSpec { name: name.into(), dimension, stroke });
        self.home_joints.push(near_home);
        self
    }

    /// Adds a parameter, SI.
    #[must_use]
    pub fn parameter(
        mut self,
        name: impl Into<String>,
        dimension: Dimension,
        nominal: f64,
        tolerance: Option<f64>,
        role: ParameterRole,
    ) -> Self {
        self.parameters.push(ParameterSpec { name: name.into(), dimension, nominal, tolerance, role });
        self
    }

    /// Adds the three coordinates `xA… yA… zA…` of the point where leg `leg` (from 0) meets the platform, m.
    #[must_use]
    pub fn platform_point(self, leg: usize, point: [f64; 3], tolerance: Option<f64>) -> Self {
        self.coordinates("A", leg, point, tolerance, |axis| ParameterRole::PlatformPoint { leg, axis })
    }

    /// Adds the three coordinates `xB… yB… zB…` of the point where leg `leg` (from 0) meets the base, m.
    #[must_use]
    pub fn base_point(self, leg: usize, point: [f64; 3], tolerance: Option<f64>) -> Self {
        self.coordinates("B", leg, point, tolerance, |axis| ParameterRole::BasePoint { leg, axis })
    }

    fn coordinates(
        mut self,
        body: &str,
        leg: usize,
        point: [f64; 3],
        tolerance: Option<f64>,
        role: impl Fn(Axis) -> ParameterRole,
    ) -> Self {
        for (axis, value) in Axis::ALL.into_iter().zip(point) {
            let name = format!("{}{body}{}", ["x", "y", "z"][axis.index()], leg + 1);
            self = self.parameter(name, Dimension::Length, value, tolerance, role(axis));
        }
        self
    }

    /// Adds passive coordinates that start at `near_home`.
    #[must_use]
    pub fn passive(mut self, near_home: &[f64]) -> Self {
        self.passive.extend_from_slice(near_home);
        self
    }

    /// States which of x, y, z, α, β, γ the joints control.
    #[must_use]
    pub fn controls(mut self, controlled: [bool; 6]) -> Self {
        self.controlled = controlled;
        self
    }
}
