//! Laws of an [`Effect`].

use std::sync::Arc;

use super::{Violation, violation};
use crate::conditions::Conditions;
use crate::effect::{
    ActiveEffect, ActsOn, AvailableData, Effect, EffectContext, Environment, Extended, Perturbation, Scan, ScanPoint,
    Site,
};
use crate::measurement::Dataset;
use crate::mechanism::{Mechanism, MotionBlock};

/// Agreement of sums of perturbations, relative.
const LINEAR: f64 = 1e-12;
/// Agreement of columns with full forward kinematics, relative to the largest motion.
const KINEMATICS: f64 = 1e-3;

/// Checks an effect on a mechanism and samples that have all that it needs.
///
/// * name, cause and remedy say something, parameters have names of their own and usual sizes above zero;
/// * nothing is missing, something is where nothing was recorded;
/// * perturbations are linear in the parameters and finite, and nothing happens where nothing is known;
/// * an effect acts on what it says: on the reading alone, or on joints and geometry alone;
/// * columns agree with what the full forward kinematics of the [`Extended`] mechanism does, and commanding a pose through
///   it leads back to the pose.
///
/// # Errors
/// The first [`Violation`].
pub fn effect(
    effect: &Arc<dyn Effect>,
    mechanism: &dyn Mechanism,
    environment: &Environment,
    data: &Dataset,
) -> Result<(), Violation> {
    let environment = Arc::new(environment.with_references_of(data));
    let context = EffectContext::new(mechanism, &environment);
    let available = AvailableData::of(data);
    words(effect.as_ref(), &context, &available)?;
    for at in places(effect.as_ref(), &context, &available) {
        for sample in data.iter() {
            let here = Here { effect, at: &at, context: &context, environment: &environment };
            here.check(&sample.joints, &sample.conditions)?;
        }
    }
    Ok(())
}

fn words(effect: &dyn Effect, context: &EffectContext<'_>, available: &AvailableData) -> Result<(), Violation> {
    const LAW: &str = "an effect says what it is";
    for (what, text) in [("name", effect.name()), ("cause", effect.cause()), ("remedy", effect.remedy())] {
        if text.trim().is_empty() {
            return Err(violation(LAW, format!("its {what} is empty")));
        }
    }
    let parameters = effect.parameters(context);
    for (k, p) in parameters.iter().enumerate() {
        if parameters[..k].iter().any(|other| other.name == p.name) {
            return Err(violation(LAW, format!("two parameters are called {}", p.name)));
        }
        if !(p.scale > 0.0 && p.scale.is_finite()) {
            return Err(violation(LAW, format!("{}: the usual size is {}", p.name, p.scale)));
        }
    }
    if parameters.is_empty() {
        return Err(violation(LAW, "it has no parameter"));
    }
    let missing = effect.missing(context, available);
    if !missing.is_empty() {
        return Err(violation("what an effect needs is there", missing.join(", ")));
    }
    Ok(())
}

/// One place of each kind of scan is enough for legs and rows; every covariate is tried.
fn places(effect: &dyn Effect, context: &EffectContext<'_>, available: &AvailableData) -> Vec<ScanPoint> {
    let middle = Some(available.samples / 2);
    let last = context.joints().saturating_sub(1);
    match effect.scan(context, available) {
        Scan::None => vec![ScanPoint::none()],
        Scan::Legs => vec![ScanPoint::leg(0), ScanPoint::leg(last)],
        Scan::Rows => vec![ScanPoint { row: middle, ..ScanPoint::none() }],
        Scan::LegsAndRows => vec![ScanPoint { row: middle, ..ScanPoint::leg(last) }],
        Scan::Covariates(names) => {
            names.into_iter().map(|name| ScanPoint { covariate: Some(name), ..ScanPoint::none() }).collect()
        }
    }
}

struct Here<'a> {
    effect: &'a Arc<dyn Effect>,
    at: &'a ScanPoint,
    context: &'a EffectContext<'a>,
    environment: &'a Arc<Environment>,
}

impl Here<'_> {
    fn check(&self, joints: &[f64], conditions: &Conditions) -> Result<(), Violation> {
        const PLACE: &str = "samples have poses";
        let mechanism = self.context.mechanism;
        let values = mechanism.values();
        let pose = mechanism
            .forward(values, joints, conditions, &mechanism.home())
            .map_err(|cause| violation(PLACE, cause.to_string()))?;
        let mut block = MotionBlock::sized_for(mechanism);
        mechanism
            .motion_block(values, joints, &pose, conditions, &mut block)
            .map_err(|cause| violation(PLACE, cause.to_string()))?;
        let perturb = |theta: &[f64], conditions: &Conditions| {
            let site =
                Site { context: self.context, values, joints, pose: &pose, conditions, joint_motion: &block.joints };
            let mut out = Perturbation::sized(values.len(), joints.len());
            self.effect.perturb(theta, self.at, &site, &mut out);
            out
        };
        let parameters = self.effect.parameters(self.context);
        let theta: Vec<f64> =
            parameters.iter().enumerate().map(|(k, p)| 0.1 * p.scale * (1.0 - 0.13 * k as f64)).collect();
        let whole = perturb(&theta, conditions);
        let numbers = |p: &Perturbation| -> Vec<f64> {
            p.parameters.iter().chain(&p.joints).chain(p.pose.iter()).copied().collect()
        };
        let mut sum = vec![0.0; numbers(&whole).len()];
        for k in 0..theta.len() {
            let mut unit = vec![0.0; theta.len()];
            unit[k] = 1.0;
            for (total, part) in sum.iter_mut().zip(numbers(&perturb(&unit, conditions))) {
                *total += theta[k] * part;
            }
        }
        let size = numbers(&whole).iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        for (k, (a, b)) in numbers(&whole).iter().zip(&sum).enumerate() {
            if !((a - b).abs() <= LINEAR * size) {
                let detail = format!("entry {k}: whole {a}, sum of its parameters {b}");
                return Err(violation("an effect is linear in its parameters", detail));
            }
        }
        let moves_platform = whole.parameters.iter().chain(&whole.joints).any(|v| *v != 0.0);
        let moves_reading = whole.pose.iter().any(|v| *v != 0.0);
        if moves_platform && self.effect.acts_on() == ActsOn::Measurement
            || moves_reading && self.effect.acts_on() == ActsOn::Mechanism
        {
            let detail = format!("it says {:?}", self.effect.acts_on());
            return Err(violation("an effect acts on what it says", detail));
        }
        if moves_platform {
            self.kinematics(joints, conditions, &theta, &whole, &block)?;
        }
        Ok(())
    }

    /// The columns against the full forward kinematics, and the way back.
    fn kinematics(
        &self,
        joints: &[f64],
        conditions: &Conditions,
        theta: &[f64],
        whole: &Perturbation,
        block: &MotionBlock,
    ) -> Result<(), Violation> {
        const LAW: &str = "columns agree with forward kinematics";
        let mechanism = self.context.mechanism;
        let fail = |law, cause: String| violation(law, cause);
        let inner = mechanism
            .with_values(mechanism.values(), mechanism.home())
            .map_err(|cause| fail("the mechanism can be copied", cause.to_string()))?;
        let active = ActiveEffect {
            effect: Arc::clone(self.effect),
            at: self.at.clone(),
            values: theta.to_vec(),
            range: std::collections::BTreeMap::new(),
        };
        let extended = Extended::new(inner, Arc::clone(self.environment), vec![active]);
        let c = extended.values();
        let home = mechanism.home();
        let plain = mechanism
            .forward(mechanism.values(), joints, conditions, &home)
            .map_err(|cause| fail(LAW, cause.to_string()))?;
        let moved = extended.forward(c, joints, conditions, &home).map_err(|cause| fail(LAW, cause.to_string()))?;
        let (found, expected) = (plain.motion_to(&moved), whole.motion(block));
        let miss = (found - expected).amax();
        if !(miss <= KINEMATICS * expected.amax() + 1e-12) {
            return Err(violation(LAW, format!("moved by {found:?}, columns say {expected:?}")));
        }
        let back = extended
            .inverse(c, &moved, conditions)
            .map_err(|cause| fail("commands lead back to the pose", cause.to_string()))?;
        let miss = back.iter().zip(joints).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if !(miss < 1e-9) {
            return Err(violation("commands lead back to the pose", format!("joints differ by {miss}")));
        }
        Ok(())
    }
}
