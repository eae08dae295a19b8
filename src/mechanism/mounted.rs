//! Any mechanism as an instrument sees it.

use nalgebra::{Matrix3, Matrix6, Vector3};

use super::mounting::Mounting;
use super::{
    Extension, ForwardQuery, GeometryError, KinematicsError, Linearization, Mechanism, MechanismCore, MotionBlock,
};
use crate::conditions::Conditions;
use crate::pose::Pose;

/// A mechanism that stands elsewhere in the frame of the measurement, and on whose platform the target sits elsewhere: its
/// pose `T` is measured as `B T A`. Its parameters, and whatever acts on it (gravity, heat), stay in the frames of its drawing.
#[derive(Debug)]
pub struct Mounted {
    inner: Box<dyn Mechanism>,
    mounting: Mounting,
    /// That of the mechanism, with the measured home.
    core: MechanismCore,
}

/// A mechanism with its base at `base` in the frame of the measurement and the target at `target` on its platform.
pub fn mount(mechanism: Box<dyn Mechanism>, base: &Pose, target: &Pose) -> Box<dyn Mechanism> {
    match mechanism.mounted(base, target) {
        Some(mounted) => mounted,
        None => Box::new(Mounted::new(mechanism, Mounting { base: *base, target: *target })),
    }
}

impl Mounted {
    pub(crate) fn new(inner: Box<dyn Mechanism>, mounting: Mounting) -> Self {
        let core = MechanismCore { home: mounting.outer(&inner.home()), ..inner.core().clone() };
        Self { inner, mounting, core }
    }

    /// The mechanism in the frames of its drawing.
    pub fn inner(&self) -> &dyn Mechanism {
        self.inner.as_ref()
    }

    /// Small motion as it is measured per small motion in the frames of the drawing, the inverse of
    /// [`Mounting::inner_motion`].
    fn outer_motion(&self, pose: &Pose, inner: &Pose) -> Matrix6<f64> {
        let turn: Matrix3<f64> = *self.mounting.base.rotation.matrix();
        let arm: Vector3<f64> = self.mounting.base.place(&inner.position) - pose.position;
        let mut m = Matrix6::zeros();
        m.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
        m.fixed_view_mut::<3, 3>(0, 3).copy_from(&(arm.cross_matrix() * turn));
        m.fixed_view_mut::<3, 3>(3, 3).copy_from(&turn);
        m
    }
}

impl Mechanism for Mounted {
    fn core(&self) -> &MechanismCore {
        &self.core
    }

    fn extension(&self) -> Option<&dyn Extension> {
        self.inner.extension()
    }

    fn with_values(&self, c: &[f64], home: Pose) -> Result<Box<dyn Mechanism>, GeometryError> {
        let inner = self.inner.with_values(c, self.mounting.inner(&home))?;
        Ok(Box::new(Self::new(inner, self.mounting)))
    }

    fn equations(&self) -> usize {
        self.inner.equations()
    }

    fn mounted(&self, base: &Pose, target: &Pose) -> Option<Box<dyn Mechanism>> {
        let inner = self.inner.with_values(self.inner.values(), self.inner.home()).ok()?;
        Some(Box::new(Self::new(inner, self.mounting.within(base, target))))
    }

    fn mounting(&self) -> Option<(Pose, Pose)> {
        Some((self.mounting.base, self.mounting.target))
    }

    fn platform_points(&self) -> Vec<Vector3<f64>> {
        self.inner.platform_points()
    }

    fn linearize(&self, c: &[f64], joints: &[f64], pose: &Pose, at: &Conditions, out: &mut Linearization) {
        let inner = self.mounting.inner(pose);
        self.inner.linearize(c, joints, &inner, at, out);
        let measured = &out.motion * self.mounting.inner_motion(pose, &inner);
        out.motion.copy_from(&measured);
    }

    fn inverse(&self, c: &[f64], pose: &Pose, at: &Conditions) -> Result<Vec<f64>, KinematicsError> {
        self.inner.inverse(c, &self.mounting.inner(pose), at)
    }

    fn forward(&self, c: &[f64], joints: &[f64], at: &Conditions, seed: &Pose) -> Result<Pose, KinematicsError> {
        Ok(self.mounting.outer(&self.inner.forward(c, joints, at, &self.mounting.inner(seed))?))
    }

    fn forward_batch(&self, c: &[f64], queries: &[ForwardQuery<'_>]) -> Vec<Result<Pose, KinematicsError>> {
        let queries: Vec<ForwardQuery<'_>> =
            queries.iter().map(|q| ForwardQuery { seed: self.mounting.inner(&q.seed), ..*q }).collect();
        let found = self.inner.forward_batch(c, &queries);
        found.into_iter().map(|pose| Ok(self.mounting.outer(&pose?))).collect()
    }

    fn motion_block(
        &self,
        c: &[f64],
        joints: &[f64],
        pose: &Pose,
        at: &Conditions,
        out: &mut MotionBlock,
    ) -> Result<(), KinematicsError> {
        let inner = self.mounting.inner(pose);
        self.inner.motion_block(c, joints, &inner, at, out)?;
        let outer = self.outer_motion(pose, &inner);
        out.parameters = outer * &out.parameters;
        out.joints = outer * &out.joints;
        Ok(())
    }
}
