//! Effects that act on the true machine and that its model has.

use std::sync::Arc;

use paracal::conditions::{Conditions, TEMP_LEGS};
use paracal::effect::{ActiveEffect, Catalogue, Environment, Extended, ScanPoint};
use paracal::mechanism::Mechanism;

use crate::dice::Dice;
use crate::machines::Design;

/// Temperature at which the geometry holds, °C.
const REFERENCE: f64 = 20.0;

enum Cause {
    /// Legs grow by this part per kelvin.
    Heat(f64),
    /// All joints move by this part too far, from home.
    Scale(f64),
}

/// An effect with its true size.
pub(crate) struct TrueEffect {
    cause: Cause,
    /// Joints of the design at home.
    home: Vec<f64>,
}

impl TrueEffect {
    pub(crate) fn draw(design: &Design, dice: &mut Dice) -> Self {
        let cause = match dice.chance(0.5) {
            true => Cause::Heat(dice.uniform(5e-6, 2.5e-5)),
            false => Cause::Scale(2e-3 * dice.normal()),
        };
        let home = design.kind.joints(&design.values, &design.home).unwrap_or_default();
        Self { cause, home }
    }

    pub(crate) fn name(&self) -> &'static str {
        match self.cause {
            Cause::Heat(_) => "thermal.legs.uniform",
            Cause::Scale(_) => "scale.common",
        }
    }

    /// The commands that make the joints act like this.
    pub(crate) fn commanded(&self, acting: &[f64], warmer: f64) -> Vec<f64> {
        match self.cause {
            Cause::Heat(part) => acting.iter().map(|a| a / (1.0 + part * warmer)).collect(),
            Cause::Scale(part) => acting.iter().zip(&self.home).map(|(a, h)| h + (a - h) / (1.0 + part)).collect(),
        }
    }

    /// Its true size.
    pub(crate) fn size(&self) -> f64 {
        match self.cause {
            Cause::Heat(part) | Cause::Scale(part) => part,
        }
    }

    /// A mechanism with the effect, of some size.
    pub(crate) fn around(&self, mechanism: Box<dyn Mechanism>, size: f64) -> Option<Box<dyn Mechanism>> {
        let catalogue = Catalogue::standard();
        let effect = Arc::clone(catalogue.get(self.name())?);
        let active = ActiveEffect { effect, at: ScanPoint::none(), values: vec![size], range: Default::default() };
        let environment = Environment {
            reference_temperature: Some(REFERENCE),
            home_joints: Some(self.home.clone()),
            ..Environment::default()
        };
        Some(Box::new(Extended::new(mechanism, Arc::new(environment), vec![active])))
    }
}

/// The state of a sample that is so much warmer than the reference.
pub(crate) fn conditions(warmer: f64) -> Conditions {
    let mut state = Conditions::unknown();
    state.covariates.insert(TEMP_LEGS.into(), REFERENCE + warmer);
    state
}
