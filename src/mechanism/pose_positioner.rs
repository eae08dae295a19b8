//! A positioner in pose space: commanded are the coordinates of the pose themselves.
//!
//! Where only a controller is known and not the mechanism behind it, the joints `h` are the six coordinates that were
//! commanded, written as the file writes poses, and the parameters `C` six offsets:
//!
//! ```text
//! f(q, h, C) = q - h - C,   J₁ = rates of the coordinates,   J₂ = ∂f/∂h = -I
//! ```
//!
//! Nothing else can be wrong with such a positioner; what depends on temperatures or gravity are effects in pose space.

use std::f64::consts::FRAC_PI_2;

use nalgebra::DMatrix;

use super::{
    GeometryError, JointSpec, KinematicsError, Linearization, Mechanism, MechanismCore, ParameterRole, ParameterSpec,
    check_held,
};
use crate::conditions::Conditions;
use crate::pose::{Pose, PoseConvention, wrapped_angle};
use crate::units::Dimension;

/// A positioner whose joints are the coordinates of the pose.
#[derive(Clone, Debug, PartialEq)]
pub struct PosePositioner {
    core: MechanismCore,
    convention: PoseConvention,
}

const NAMES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

fn dimension(coordinate: usize) -> Dimension {
    if coordinate < 3 { Dimension::Length } else { Dimension::Angle }
}

impl PosePositioner {
    /// A positioner with offsets in the coordinates of a convention, m and rad. `tolerance` is 1σ of an offset of the
    /// position, m, and of an angle, rad. Its joints are called `cmd_x` … `cmd_rz`, its parameters `dx` … `drz`.
    ///
    /// # Errors
    /// [`GeometryError`] for numbers that are not finite, and for a home with `β = ±90°`, where the angles are singular.
    pub fn new(
        name: impl Into<String>,
        convention: PoseConvention,
        home: Pose,
        offsets: [f64; 6],
        tolerance: Option<[f64; 2]>,
    ) -> Result<Self, GeometryError> {
        let spec = |k: usize| ParameterSpec {
            name: format!("d{}", NAMES[k]),
            dimension: dimension(k),
            nominal: offsets[k],
            tolerance: tolerance.map(|t| t[usize::from(k >= 3)]),
            role: ParameterRole::PoseOffset { coordinate: k },
        };
        let joint = |k: usize| JointSpec { name: format!("cmd_{}", NAMES[k]), dimension: dimension(k), stroke: None };
        let core = MechanismCore::new(name, (0..6).map(spec).collect(), (0..6).map(joint).collect(), home);
        let made = Self { core, convention };
        made.check()?;
        Ok(made)
    }

    /// The offsets, m and rad.
    pub fn offsets(&self) -> &[f64] {
        self.values()
    }

    fn check(&self) -> Result<(), GeometryError> {
        if let Some((spec, value)) = self.parameters().iter().zip(self.values()).find(|(_, v)| !v.is_finite()) {
            return Err(GeometryError::Other(format!("offset {} is not a finite number ({value})", spec.name)));
        }
        let joints = self.inverse(self.values(), &self.home(), &Conditions::unknown()).map_err(GeometryError::Home)?;
        check_held(self, &joints)
    }
}

impl Mechanism for PosePositioner {
    fn core(&self) -> &MechanismCore {
        &self.core
    }

    fn with_values(&self, c: &[f64], home: Pose) -> Result<Box<dyn Mechanism>, GeometryError> {
        let other = Self { core: self.core.with_values(c, home)?, ..*self };
        other.check()?;
        Ok(Box::new(other))
    }

    fn equations(&self) -> usize {
        6
    }

    fn linearize(&self, c: &[f64], joints: &[f64], pose: &Pose, _at: &Conditions, out: &mut Linearization) {
        let q = self.convention.coordinates(pose);
        for k in 0..6 {
            let off = q[k] - joints[k] - c[k];
            out.residual[k] = if k < 3 { off } else { wrapped_angle(off) };
        }
        out.motion.copy_from(&self.convention.rates(pose));
        let minus = -DMatrix::identity(6, 6);
        out.parameters.copy_from(&minus);
        out.joints.copy_from(&minus);
    }

    fn inverse(&self, c: &[f64], pose: &Pose, _at: &Conditions) -> Result<Vec<f64>, KinematicsError> {
        if !pose.is_finite() {
            return Err(KinematicsError::NotFinite { what: "the pose".into() });
        }
        Ok(self.convention.coordinates(pose).iter().zip(c).map(|(q, c)| q - c).collect())
    }

    fn forward(&self, c: &[f64], joints: &[f64], _at: &Conditions, _seed: &Pose) -> Result<Pose, KinematicsError> {
        if joints.len() != 6 {
            return Err(KinematicsError::JointCount { expected: 6, found: joints.len() });
        }
        let q: [f64; 6] = std::array::from_fn(|k| joints[k] + c[k]);
        if q.iter().any(|v| !v.is_finite()) {
            return Err(KinematicsError::NotFinite { what: "a commanded coordinate".into() });
        }
        // Beyond a right angle another set of angles states the pose.
        if q[4].abs() >= FRAC_PI_2 {
            return Err(KinematicsError::OtherBranch);
        }
        Ok(self.convention.pose(&q))
    }
}
