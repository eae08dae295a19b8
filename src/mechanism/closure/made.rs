//! The mechanism that a closure makes.

use std::borrow::Cow;

use nalgebra::{Matrix6, Vector3, Vector6};

use super::check::{check_dependence, check_outline};
use super::evaluation::{Derivatives, Place, Wanted, derivatives};
use super::inverse::{Root, Rows, root};
use super::passive::{eliminated, solved};
use super::pattern::Pattern;
use super::{Closure, Outline};
use crate::conditions::Conditions;
use crate::mechanism::mounting::Mounting;
use crate::mechanism::{
    Body, GeometryError, KinematicsError, Linearization, Mechanism, MechanismCore, MotionBlock, ParameterSpec,
    characteristic_length, check_held, forward_by_rows, inverse_motion, motion_block_by_closure,
};
use crate::pose::Pose;

/// Rounds in which the attitude that the platform takes is found.
const SERVING_ROUNDS: usize = 20;

/// A [`Mechanism`] whose closure is a [`Closure`].
///
/// Parameters may be left out of the identification ([`identifying`](Self::identifying)); they keep their values. A
/// mechanism may be [`mounted`](Mechanism::mounted) in the frames of a measurement; its parameters stay those of
/// the drawing.
#[derive(Clone, Debug)]
pub struct ClosureMechanism<C> {
    closure: C,
    outline: Outline,
    /// All parameters, identified or not.
    all: Vec<f64>,
    /// Which of them are identified.
    free: Vec<usize>,
    /// With the parameters that are identified, and home in the frames of the measurement.
    core: MechanismCore,
    pattern: Pattern,
    joint_pattern: Pattern,
    mounting: Option<Mounting>,
    /// Home and its joints, in the mechanism's own frames.
    home: Root,
    size: f64,
    /// Closure equations without passive ones.
    equations: usize,
}

impl<C: Closure> ClosureMechanism<C> {
    /// The mechanism of a closure.
    ///
    /// # Errors
    /// [`GeometryError`] if the outline contradicts itself or [`Closure::depends`], if the loops do not close at home,
    /// or if the joints do not hold the platform there.
    pub fn new(closure: C, outline: Outline) -> Result<Self, GeometryError> {
        let nominal: Vec<f64> = outline.parameters.iter().map(|p| p.nominal).collect();
        let all: Vec<usize> = (0..nominal.len()).collect();
        Self::make(closure, outline, nominal, all, None)
    }

    /// This mechanism with only some parameters identified; the others keep their values.
    ///
    /// # Errors
    /// [`GeometryError::Outline`] if no parameter is left.
    pub fn identifying(&self, keep: impl Fn(&ParameterSpec) -> bool) -> Result<Self, GeometryError> {
        let free = (0..self.all.len()).filter(|k| keep(&self.outline.parameters[*k])).collect();
        Self::make(self.closure.clone(), self.outline.clone(), self.all.clone(), free, self.mounting)
    }

    /// Its outline, with the nominal values of all parameters.
    pub fn outline(&self) -> &Outline {
        &self.outline
    }

    /// The values of all parameters in the order of the outline, identified or not.
    pub fn all_values(&self) -> &[f64] {
        &self.all
    }

    /// Home in the mechanism's own frames.
    pub fn own_home(&self) -> Pose {
        self.home.pose
    }

    /// The closure.
    pub fn closure(&self) -> &C {
        &self.closure
    }

    fn make(
        closure: C,
        outline: Outline,
        all: Vec<f64>,
        free: Vec<usize>,
        mounting: Option<Mounting>,
    ) -> Result<Self, GeometryError> {
        check_outline(&outline, &all, &free)?;
        let pattern = Pattern::of(&closure, &outline, &free);
        let joint_pattern = Pattern::of(&closure, &outline, &[]);
        let core = MechanismCore {
            name: outline.name.clone(),
            parameters: free.iter().map(|k| outline.parameters[*k].clone()).collect(),
            values: free.iter().map(|k| all[*k]).collect(),
            joints: outline.joints.clone(),
            home: outline.home,
        };
        let home = Root { pose: outline.home, joints: outline.home_joints.clone() };
        let mut made = Self {
            equations: outline.equations - outline.passive.len(),
            closure,
            outline,
            all,
            free,
            core,
            pattern,
            joint_pattern,
            mounting,
            home,
            size: 1.0,
        };
        made.size = characteristic_length(&made);
        check_dependence(&made.closure, &made.outline, &made.all, &made.free, &made.pattern)?;
        let start = made.home.pose;
        made.settle_home(&start)?;
        check_held(&made, &made.home.joints)?;
        Ok(made)
    }

    /// Moves home to the root at which its controlled coordinates are those of `pose` (the mechanism's own frames).
    fn settle_home(&mut self, pose: &Pose) -> Result<(), GeometryError> {
        self.home = self
            .root_at(&self.all, pose, &Conditions::unknown())
            .map_err(|e| GeometryError::ClosureAtHome(Box::new(e)))?;
        self.core.home = self.outer(&self.home.pose);
        Ok(())
    }

    fn inner(&self, pose: &Pose) -> Pose {
        self.mounting.map_or(*pose, |m| m.inner(pose))
    }

    fn outer(&self, pose: &Pose) -> Pose {
        self.mounting.map_or(*pose, |m| m.outer(pose))
    }

    /// The mechanism's own pose whose controlled coordinates serve a pose as it is measured. Where the joints do not control
    /// the attitude, the platform will take another one than was asked for, and a target beside its origin another place:
    /// the position that is asked for is met with the attitude that will be taken.
    fn served(&self, all: &[f64], pose: &Pose, at: &Conditions) -> Result<Pose, KinematicsError> {
        let mut inner = self.inner(pose);
        let free = (3..6).any(|k| !self.outline.controlled[k]);
        if self.mounting.is_none() || !free {
            return Ok(inner);
        }
        for _ in 0..SERVING_ROUNDS {
            let taken = self.root_at(all, &inner, at)?.pose;
            let (mut q, found) = (inner.coordinates(), taken.coordinates());
            (3..6).filter(|k| !self.outline.controlled[*k]).for_each(|k| q[k] = found[k]);
            let attitude = self.outer(&Pose::from_coordinates(&q)).rotation;
            let next = self.inner(&Pose { position: pose.position, rotation: attitude });
            let settled = inner.motion_to(&next).amax() < 1e-13 * self.size.max(1.0);
            inner = next;
            if settled {
                break;
            }
        }
        Ok(inner)
    }

    /// All parameters, with those that are identified at `c`.
    fn with_parameters<'c>(&self, c: &'c [f64]) -> Cow<'c, [f64]> {
        if self.free.len() == self.all.len() {
            return Cow::Borrowed(c);
        }
        let mut all = self.all.clone();
        for (k, value) in self.free.iter().zip(c) {
            all[*k] = *value;
        }
        Cow::Owned(all)
    }

    /// Rows without passive coordinates, in the mechanism's own frames; NaN where the passive coordinates have no root.
    fn rows_at(
        &self,
        all: &[f64],
        joints: &[f64],
        pose: &Pose,
        at: &Conditions,
        (pattern, free, wanted): (&Pattern, &[usize], Wanted),
    ) -> Derivatives {
        let mut place = Place { pose, joints, parameters: all, passive: &[], at };
        let z = if self.outline.passive.is_empty() {
            Some(Vec::new())
        } else {
            solved(&self.closure, &self.outline, &self.joint_pattern, &place)
        };
        let lost = vec![f64::NAN; self.outline.passive.len()];
        place.passive = z.as_deref().unwrap_or(&lost);
        eliminated(derivatives(&self.closure, pattern, free, self.outline.equations, &place, wanted))
    }

    fn root_at(&self, all: &[f64], pose: &Pose, at: &Conditions) -> Result<Root, KinematicsError> {
        let dependent: Vec<usize> = (0..6).filter(|k| !self.outline.controlled[*k]).collect();
        root(&AtParameters { mechanism: self, all, at }, pose, &dependent, &self.home, self.size)
    }
}

/// The closure with its parameters held.
struct AtParameters<'a, C> {
    mechanism: &'a ClosureMechanism<C>,
    all: &'a [f64],
    at: &'a Conditions,
}

impl<C: Closure> Rows for AtParameters<'_, C> {
    fn equations(&self) -> usize {
        self.mechanism.equations
    }

    fn rows(&self, joints: &[f64], pose: &Pose) -> Derivatives {
        let m = self.mechanism;
        m.rows_at(self.all, joints, pose, self.at, (&m.joint_pattern, &[], Wanted::All))
    }
}

impl<C: Closure> Mechanism for ClosureMechanism<C> {
    fn core(&self) -> &MechanismCore {
        &self.core
    }

    fn with_values(&self, c: &[f64], home: Pose) -> Result<Box<dyn Mechanism>, GeometryError> {
        if c.len() != self.values().len() {
            return Err(GeometryError::ParameterCount { expected: self.values().len(), found: c.len() });
        }
        if let Some(k) = c.iter().position(|v| !v.is_finite()) {
            return Err(GeometryError::Outline(format!(
                "{} is {}; every value of a mechanism must be a number",
                self.parameters()[k].name,
                c[k]
            )));
        }
        let mut other = self.clone();
        other.all = self.with_parameters(c).into_owned();
        other.core.values = c.to_vec();
        let inner = self.inner(&home);
        // The branch is that of the old home; values with which it cannot be reached are refused where they are used.
        if other.settle_home(&inner).is_err() {
            other.home.pose = inner;
        }
        other.core.home = home;
        Ok(Box::new(other))
    }

    fn equations(&self) -> usize {
        self.equations
    }

    fn controlled(&self) -> [bool; 6] {
        self.outline.controlled
    }

    fn platform_points(&self) -> Vec<Vector3<f64>> {
        let points = Body::Platform.points_among(&self.outline.parameters, &self.all);
        points.into_iter().map(|(_, point)| point).collect()
    }

    fn mounting(&self) -> Option<(Pose, Pose)> {
        self.mounting.map(|m| (m.base, m.target))
    }

    fn mounted(&self, base: &Pose, target: &Pose) -> Option<Box<dyn Mechanism>> {
        let mut other = self.clone();
        other.mounting = Some(self.mounting.unwrap_or_default().within(base, target));
        other.core.home = base.compose(&self.home()).compose(target);
        Some(Box::new(other))
    }

    fn linearize(&self, c: &[f64], joints: &[f64], pose: &Pose, at: &Conditions, out: &mut Linearization) {
        let inner = self.inner(pose);
        let all = self.with_parameters(c);
        let d = self.rows_at(&all, joints, &inner, at, (&self.pattern, &self.free, Wanted::All));
        out.residual.copy_from(&d.residual);
        match &self.mounting {
            Some(m) => out.motion.copy_from(&(&d.motion * m.inner_motion(pose, &inner))),
            None => out.motion.copy_from(&d.motion),
        }
        let (parameters, joints) = (self.free.len(), joints.len());
        out.parameters.copy_from(&d.columns.columns(0, parameters));
        out.joints.copy_from(&d.columns.columns(parameters, joints));
    }

    fn motion_block(
        &self,
        c: &[f64],
        joints: &[f64],
        pose: &Pose,
        at: &Conditions,
        out: &mut MotionBlock,
    ) -> Result<(), KinematicsError> {
        if self.equations != 6 || !self.outline.passive.is_empty() {
            return motion_block_by_closure(self, c, joints, pose, at, out);
        }
        // Six equations whose sparsity is known: one small inverse, and a column of it for each entry of J2.
        let inner = self.inner(pose);
        let all = self.with_parameters(c);
        let d = self.rows_at(&all, joints, &inner, at, (&self.pattern, &self.free, Wanted::All));
        let mut motion: Matrix6<f64> = d.motion.fixed_view::<6, 6>(0, 0).into_owned();
        if let Some(m) = &self.mounting {
            motion *= m.inner_motion(pose, &inner);
        }
        let inverse = inverse_motion(&motion)?;
        let (parameters, joints) = (out.parameters.column_iter_mut(), out.joints.column_iter_mut());
        for (column, mut to) in parameters.chain(joints).enumerate() {
            let mut moved = Vector6::zeros();
            for row in self.pattern.rows(column) {
                moved -= inverse.column(*row) * d.columns[(*row, column)];
            }
            to.copy_from(&moved);
        }
        Ok(())
    }

    fn inverse(&self, c: &[f64], pose: &Pose, at: &Conditions) -> Result<Vec<f64>, KinematicsError> {
        if !pose.is_finite() {
            return Err(KinematicsError::NotFinite { what: "the pose".into() });
        }
        let all = self.with_parameters(c);
        Ok(self.root_at(&all, &self.served(&all, pose, at)?, at)?.joints)
    }

    fn forward(&self, c: &[f64], joints: &[f64], at: &Conditions, seed: &Pose) -> Result<Pose, KinematicsError> {
        let expected = self.outline.joints.len();
        if joints.len() != expected {
            return Err(KinematicsError::JointCount { expected, found: joints.len() });
        }
        let all = self.with_parameters(c);
        let rows = |joints: &[f64], pose: &Pose| {
            let d = self.rows_at(&all, joints, pose, at, (&self.joint_pattern, &[], Wanted::Motion));
            (d.residual, d.motion)
        };
        let seed = self.inner(seed);
        let found = forward_by_rows(joints, &seed, || Ok(self.root_at(&all, &seed, at)?.joints), rows)?;
        Ok(self.outer(&found))
    }
}
