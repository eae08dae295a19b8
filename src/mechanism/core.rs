//! What every mechanism keeps about itself.

use super::{GeometryError, JointSpec, ParameterSpec};
use crate::pose::Pose;

/// Name, parameters, joints and home of a mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct MechanismCore {
    /// Display name.
    pub name: String,
    /// Name, unit, nominal value, tolerance and role of each parameter: the order of `C`, eq. (15).
    pub parameters: Vec<ParameterSpec>,
    /// The parameter values of this very mechanism (nominal or calibrated), SI, in the order of the parameters.
    pub values: Vec<f64>,
    /// Name, dimension and stroke of each joint coordinate.
    pub joints: Vec<JointSpec>,
    /// The pose from which forward kinematics starts and about which the workspace lies.
    pub home: Pose,
}

impl MechanismCore {
    /// Of a mechanism whose parameters have their nominal values.
    pub fn new(name: impl Into<String>, parameters: Vec<ParameterSpec>, joints: Vec<JointSpec>, home: Pose) -> Self {
        let values = parameters.iter().map(|p| p.nominal).collect();
        Self { name: name.into(), parameters, values, joints, home }
    }

    /// With other values and another home.
    ///
    /// # Errors
    /// [`GeometryError::ParameterCount`] for another number of values.
    pub fn with_values(&self, c: &[f64], home: Pose) -> Result<Self, GeometryError> {
        let expected = self.parameters.len();
        if c.len() != expected {
            return Err(GeometryError::ParameterCount { expected, found: c.len() });
        }
        Ok(Self { values: c.to_vec(), home, ..self.clone() })
    }
}
