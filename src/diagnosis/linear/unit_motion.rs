//! Unit displacements, for tests of single places that know no cause: of each joint, and of each coordinate of what is read.

use crate::effect::{ActsOn, AvailableData, Effect, EffectContext, EffectParameter, Perturbation, ScanPoint, Site};
use crate::units::Dimension;

/// Where an error acts that has no name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// A joint, from 0.
    Joint(usize),
    /// A coordinate of the platform as the instrument sees it: 0 to 2 are shifts along the axes of the base, 3 to 5 turns
    /// about them.
    Coordinate(usize),
}

/// Everything of one kind, each displaced by one unit; it is no effect of the catalogue.
#[derive(Clone, Copy, Debug)]
pub(crate) enum UnitMotion {
    /// The joints.
    Joints,
    /// The coordinates of the platform as it is seen.
    Coordinates,
}

impl Effect for UnitMotion {
    fn name(&self) -> &str {
        match self {
            Self::Joints => "unit joints",
            Self::Coordinates => "unit coordinates",
        }
    }
    fn cause(&self) -> &str {
        ""
    }
    fn remedy(&self) -> &str {
        ""
    }
    fn acts_on(&self) -> ActsOn {
        match self {
            Self::Joints => ActsOn::Mechanism,
            Self::Coordinates => ActsOn::Measurement,
        }
    }
    fn missing(&self, _: &EffectContext<'_>, _: &AvailableData) -> Vec<String> {
        Vec::new()
    }
    fn parameters(&self, context: &EffectContext<'_>) -> Vec<EffectParameter> {
        let count = match self {
            Self::Joints => context.joints(),
            Self::Coordinates => 6,
        };
        (0..count).map(|k| EffectParameter::new(k.to_string(), Dimension::None, 1.0)).collect()
    }
    fn covariates(&self, _: &ScanPoint) -> Vec<String> {
        Vec::new()
    }
    fn perturb(&self, theta: &[f64], _: &ScanPoint, _: &Site<'_>, out: &mut Perturbation) {
        let changed = match self {
            Self::Joints => out.joints.as_mut_slice(),
            Self::Coordinates => out.pose.as_mut_slice(),
        };
        changed.iter_mut().zip(theta).for_each(|(d, t)| *d += t);
    }
}
