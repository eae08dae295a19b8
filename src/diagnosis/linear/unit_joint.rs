//! A displacement of the joints by one unit, for tests of single legs that know no cause.

use crate::effect::{AvailableData, Effect, EffectContext, EffectParameter, Perturbation, ScanPoint, Site};
use crate::units::Dimension;

/// The joints, each displaced by one unit; it is no effect of the catalogue.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UnitJoint;

impl Effect for UnitJoint {
    fn name(&self) -> &str {
        "unit"
    }
    fn cause(&self) -> &str {
        ""
    }
    fn remedy(&self) -> &str {
        ""
    }
    fn missing(&self, _: &EffectContext<'_>, _: &AvailableData) -> Vec<String> {
        Vec::new()
    }
    fn parameters(&self, context: &EffectContext<'_>) -> Vec<EffectParameter> {
        (0..context.joints()).map(|k| EffectParameter::new(k.to_string(), Dimension::None, 1.0)).collect()
    }
    fn covariates(&self, _: &ScanPoint) -> Vec<String> {
        Vec::new()
    }
    fn perturb(&self, theta: &[f64], _: &ScanPoint, _: &Site<'_>, out: &mut Perturbation) {
        out.joints.iter_mut().zip(theta).for_each(|(d, t)| *d += t);
    }
}
