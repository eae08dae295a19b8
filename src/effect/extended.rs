//! A mechanism with effects, which is again a mechanism.

use std::any::Any;
use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::Vector3;

use super::context::Home;
use super::{ActsOn, Effect, EffectContext, EffectParameter, Environment, Perturbation, ScanPoint, Site};
use crate::conditions::Conditions;
use crate::mechanism::mounting::Mounting;
use crate::mechanism::{
    Extension, GeometryError, KinematicsError, Linearization, Mechanism, MechanismCore, MotionBlock, Mounted,
    ParameterRole, ParameterSpec,
};
use crate::pose::Pose;

/// An effect at a place of its scan, with values.
#[derive(Clone, Debug)]
pub struct ActiveEffect {
    /// The effect.
    pub effect: Arc<dyn Effect>,
    /// Leg, row and covariate.
    pub at: ScanPoint,
    /// Values of its parameters, SI.
    pub values: Vec<f64>,
    /// Covariates on which it was fitted, with their smallest and largest value.
    pub range: BTreeMap<String, [f64; 2]>,
}

impl ActiveEffect {
    /// Display name, such as `drift.leg[leg=3]`.
    pub fn label(&self) -> String {
        label(self.effect.name(), &self.at)
    }

    /// The effects with the next of these values, as many as each has.
    pub fn with_values(effects: &[Self], values: impl IntoIterator<Item = f64>) -> Vec<Self> {
        let mut next = values.into_iter();
        let mut effects = effects.to_vec();
        for effect in &mut effects {
            for (value, new) in effect.values.iter_mut().zip(&mut next) {
                *value = new;
            }
        }
        effects
    }

    /// Its parameters as parameters of a mechanism or of a measurement.
    pub(super) fn specs(&self, context: &EffectContext<'_>) -> Vec<ParameterSpec> {
        let label = self.label();
        let spec = |(p, value): (EffectParameter, &f64)| ParameterSpec {
            name: format!("{label}.{}", p.name),
            dimension: p.dimension,
            nominal: *value,
            // Whatever an effect does, it is rarely more than ten times its usual size.
            tolerance: Some(TOLERATED * p.scale),
            role: ParameterRole::Other,
        };
        self.effect.parameters(context).into_iter().zip(&self.values).map(spec).collect()
    }
}

/// A mechanism without the effects around it; itself if there are none.
pub fn without_effects(mechanism: &dyn Mechanism) -> &dyn Mechanism {
    extended(mechanism).map_or(mechanism, Extended::inner)
}

/// The effects around a mechanism, also through whatever wraps it and hands on its
/// [`extension`](Mechanism::extension).
pub fn effects_of(mechanism: &dyn Mechanism) -> &[ActiveEffect] {
    extended(mechanism).map_or(&[], Extended::effects)
}

fn extended(mechanism: &dyn Mechanism) -> Option<&Extended> {
    (mechanism.extension()? as &dyn Any).downcast_ref()
}

/// Prior standard deviation of an effect's parameter over its usual size.
const TOLERATED: f64 = 10.0;

/// `name[leg=3,row=40]`, legs from 1.
pub(crate) fn label(name: &str, at: &ScanPoint) -> String {
    let leg = at.leg.map(|leg| format!("leg={}", leg + 1));
    let row = at.row.map(|row| format!("row={row}"));
    let covariate = at.covariate.as_ref().map(|c| format!("of={c}"));
    let lag = at.lag.map(|lag| format!("lag_s={lag}"));
    let places: Vec<String> = [leg, row, covariate, lag].into_iter().flatten().collect();
    if places.is_empty() { name.to_owned() } else { format!("{name}[{}]", places.join(",")) }
}

/// A mechanism whose joints and geometry are changed by effects.
///
/// Its parameters are those of the mechanism, then those of its effects. Forward kinematics alternates between the
/// pose and what the effects do there until both settle; effects are small, so that three rounds are usual.
/// Derivatives leave out how an effect changes with the pose, one part in about 10⁵ of `J₁`.
#[derive(Debug)]
pub struct Extended {
    inner: Box<dyn Mechanism>,
    environment: Arc<Environment>,
    home: Home,
    effects: Vec<ActiveEffect>,
    /// That of the mechanism, with the parameters of the effects behind its own.
    core: MechanismCore,
}

/// Rounds of pose and effects in turn.
const ROUNDS: usize = 30;
/// Below this change of a pose or a joint, m and rad, the rounds end.
const SETTLED: f64 = 1e-14;

impl Extended {
    /// A mechanism with effects; those that act on the measurement are left out (see [`super::WithInstrumentEffects`]).
    pub fn new(inner: Box<dyn Mechanism>, environment: Arc<Environment>, effects: Vec<ActiveEffect>) -> Self {
        let effects: Vec<ActiveEffect> =
            effects.into_iter().filter(|e| e.effect.acts_on() == ActsOn::Mechanism).collect();
        let home = Home::of(inner.as_ref(), &environment);
        let mut core = inner.core().clone();
        {
            let context = EffectContext::with_home(inner.as_ref(), &environment, home.clone());
            for effect in &effects {
                core.parameters.extend(effect.specs(&context));
                core.values.extend(&effect.values);
            }
        }
        Self { inner, environment, home, effects, core }
    }

    /// The mechanism without effects.
    pub fn inner(&self) -> &dyn Mechanism {
        self.inner.as_ref()
    }

    /// The effects with their present values.
    pub fn effects(&self) -> &[ActiveEffect] {
        &self.effects
    }

    /// Surroundings of the mechanism.
    pub fn environment(&self) -> &Arc<Environment> {
        &self.environment
    }

    fn context(&self) -> EffectContext<'_> {
        EffectContext::with_home(self.inner.as_ref(), &self.environment, self.home.clone())
    }

    /// Parameters of the mechanism and of the effects.
    fn split<'c>(&self, c: &'c [f64]) -> (&'c [f64], &'c [f64]) {
        c.split_at(self.inner.parameters().len())
    }

    /// Parameters and joints as the effects change them at a pose.
    fn perturbed(
        &self,
        c: &[f64],
        joints: &[f64],
        pose: &Pose,
        at: &Conditions,
    ) -> Result<(Vec<f64>, Vec<f64>), KinematicsError> {
        let (inner, theta) = self.split(c);
        let sum = self.total(inner, theta, joints, pose, at)?;
        let add = |values: &[f64], by: &[f64]| values.iter().zip(by).map(|(v, d)| v + d).collect();
        Ok((add(inner, &sum.parameters), add(joints, &sum.joints)))
    }

    fn total(
        &self,
        inner: &[f64],
        theta: &[f64],
        joints: &[f64],
        pose: &Pose,
        at: &Conditions,
    ) -> Result<Perturbation, KinematicsError> {
        if theta.iter().all(|v| *v == 0.0) {
            return Ok(Perturbation::sized(inner.len(), joints.len()));
        }
        let mut block = MotionBlock::sized_for(self.inner.as_ref());
        self.inner.motion_block(inner, joints, pose, at, &mut block)?;
        let context = self.context();
        let site = Site { context: &context, values: inner, joints, pose, conditions: at, joint_motion: &block.joints };
        let mut sum = Perturbation::sized(inner.len(), joints.len());
        let mut first = 0;
        for effect in &self.effects {
            let values = &theta[first..first + effect.values.len()];
            if values.iter().any(|v| *v != 0.0) {
                effect.effect.perturb(values, &effect.at, &site, &mut sum);
            }
            first += effect.values.len();
        }
        Ok(sum)
    }

    /// What each parameter of the effects does at a pose, per unit.
    fn unit_perturbations(
        &self,
        inner: &[f64],
        joints: &[f64],
        pose: &Pose,
        at: &Conditions,
        block: &MotionBlock,
    ) -> Vec<Perturbation> {
        let context = self.context();
        let site = Site { context: &context, values: inner, joints, pose, conditions: at, joint_motion: &block.joints };
        Perturbation::per_unit(&self.effects, &site)
    }
}

impl Extension for Extended {
    fn inner(&self) -> &dyn Mechanism {
        self.inner()
    }
}

impl Mechanism for Extended {
    fn core(&self) -> &MechanismCore {
        &self.core
    }

    fn extension(&self) -> Option<&dyn Extension> {
        Some(self)
    }

    fn with_values(&self, c: &[f64], home: Pose) -> Result<Box<dyn Mechanism>, GeometryError> {
        if c.len() != self.parameters().len() {
            return Err(GeometryError::ParameterCount { expected: self.parameters().len(), found: c.len() });
        }
        let (inner, theta) = self.split(c);
        let effects = ActiveEffect::with_values(&self.effects, theta.iter().copied());
        let inner = self.inner.with_values(inner, home)?;
        let mut made = Self::new(inner, Arc::clone(&self.environment), effects);
        // The values that effects had in the file stay the nominal ones, and they go on measuring from the same home.
        made.core.parameters.clone_from(&self.core.parameters);
        made.home.clone_from(&self.home);
        Ok(Box::new(made))
    }

    fn equations(&self) -> usize {
        self.inner.equations()
    }

    fn controlled(&self) -> [bool; 6] {
        self.inner.controlled()
    }

    /// Directions of effects, such as gravity, are those of the drawing, so that it is not carried into other frames.
    fn mounted(&self, base: &Pose, target: &Pose) -> Option<Box<dyn Mechanism>> {
        let same = self.with_values(self.values(), self.home()).ok()?;
        Some(Box::new(Mounted::new(same, Mounting { base: *base, target: *target })))
    }

    fn mounting(&self) -> Option<(Pose, Pose)> {
        self.inner.mounting()
    }

    fn platform_points(&self) -> Vec<Vector3<f64>> {
        self.inner.platform_points()
    }

    fn linearize(&self, c: &[f64], joints: &[f64], pose: &Pose, at: &Conditions, out: &mut Linearization) {
        let (inner, _) = self.split(c);
        let l = inner.len();
        let Ok((values, moved)) = self.perturbed(c, joints, pose, at) else {
            out.residual.fill(f64::NAN);
            return;
        };
        let mut plain = Linearization::sized_for(self.inner.as_ref());
        self.inner.linearize(&values, &moved, pose, at, &mut plain);
        let mut block = MotionBlock::sized_for(self.inner.as_ref());
        if self.inner.motion_block(&values, &moved, pose, at, &mut block).is_err() {
            out.residual.fill(f64::NAN);
            return;
        }
        for (k, unit) in self.unit_perturbations(inner, joints, pose, at, &block).iter().enumerate() {
            let mut column = out.parameters.column_mut(l + k);
            column.fill(0.0);
            for (j, v) in unit.parameters.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                column.axpy(*v, &plain.parameters.column(j), 1.0);
            }
            for (j, v) in unit.joints.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                column.axpy(*v, &plain.joints.column(j), 1.0);
            }
        }
        out.parameters.columns_mut(0, l).copy_from(&plain.parameters);
        out.residual.copy_from(&plain.residual);
        out.motion.copy_from(&plain.motion);
        out.joints.copy_from(&plain.joints);
    }

    fn inverse(&self, c: &[f64], pose: &Pose, at: &Conditions) -> Result<Vec<f64>, KinematicsError> {
        let (inner, theta) = self.split(c);
        let mut joints = self.inner.inverse(inner, pose, at)?;
        for _ in 0..ROUNDS {
            let sum = self.total(inner, theta, &joints, pose, at)?;
            let values: Vec<f64> = inner.iter().zip(&sum.parameters).map(|(v, d)| v + d).collect();
            let mut next = self.inner.inverse(&values, pose, at)?;
            next.iter_mut().zip(&sum.joints).for_each(|(h, d)| *h -= d);
            let change = joints.iter().zip(&next).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            joints = next;
            // Also where a number is not finite.
            if !(change > SETTLED) {
                break;
            }
        }
        Ok(joints)
    }

    fn forward(&self, c: &[f64], joints: &[f64], at: &Conditions, seed: &Pose) -> Result<Pose, KinematicsError> {
        let (inner, _) = self.split(c);
        let mut pose = self.inner.forward(inner, joints, at, seed)?;
        for _ in 0..ROUNDS {
            let (values, moved) = self.perturbed(c, joints, &pose, at)?;
            let next = self.inner.forward(&values, &moved, at, &pose)?;
            let change = pose.motion_to(&next).amax();
            pose = next;
            if !(change > SETTLED) {
                break;
            }
        }
        Ok(pose)
    }

    fn motion_block(
        &self,
        c: &[f64],
        joints: &[f64],
        pose: &Pose,
        at: &Conditions,
        out: &mut MotionBlock,
    ) -> Result<(), KinematicsError> {
        let (inner, _) = self.split(c);
        let (values, moved) = self.perturbed(c, joints, pose, at)?;
        let mut block = MotionBlock::sized_for(self.inner.as_ref());
        self.inner.motion_block(&values, &moved, pose, at, &mut block)?;
        for (k, unit) in self.unit_perturbations(inner, joints, pose, at, &block).iter().enumerate() {
            out.parameters.set_column(inner.len() + k, &unit.motion(&block));
        }
        out.parameters.columns_mut(0, inner.len()).copy_from(&block.parameters);
        out.joints.copy_from(&block.joints);
        Ok(())
    }
}
