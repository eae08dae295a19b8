//! A mechanism around another one.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use paracal::conditions::Conditions;
use paracal::mechanism::{
    Extension, GeometryError, KinematicsError, Linearization, Mechanism, MechanismCore, MotionBlock,
};
use paracal::pose::Pose;

/// Another mechanism under another name, which counts how often its forward kinematics is asked for.
#[derive(Debug)]
pub struct Wrapped {
    core: MechanismCore,
    inner: Box<dyn Mechanism>,
    forwards: Arc<AtomicUsize>,
}

impl Wrapped {
    pub fn around(inner: Box<dyn Mechanism>) -> Self {
        Self::counting(inner, Arc::default())
    }

    fn counting(inner: Box<dyn Mechanism>, forwards: Arc<AtomicUsize>) -> Self {
        Self { core: MechanismCore { name: "renamed".into(), ..inner.core().clone() }, inner, forwards }
    }

    /// Forward kinematics of this mechanism and of all that were made of it.
    pub fn forwards(&self) -> usize {
        self.forwards.load(Ordering::Relaxed)
    }
}

impl Mechanism for Wrapped {
    fn core(&self) -> &MechanismCore {
        &self.core
    }
    fn with_values(&self, c: &[f64], home: Pose) -> Result<Box<dyn Mechanism>, GeometryError> {
        Ok(Box::new(Self::counting(self.inner.with_values(c, home)?, Arc::clone(&self.forwards))))
    }
    fn equations(&self) -> usize {
        self.inner.equations()
    }
    fn extension(&self) -> Option<&dyn Extension> {
        self.inner.extension()
    }
    fn linearize(&self, c: &[f64], joints: &[f64], pose: &Pose, at: &Conditions, out: &mut Linearization) {
        self.inner.linearize(c, joints, pose, at, out);
    }
    fn inverse(&self, c: &[f64], pose: &Pose, at: &Conditions) -> Result<Vec<f64>, KinematicsError> {
        self.inner.inverse(c, pose, at)
    }
    fn forward(&self, c: &[f64], joints: &[f64], at: &Conditions, seed: &Pose) -> Result<Pose, KinematicsError> {
        self.forwards.fetch_add(1, Ordering::Relaxed);
        self.inner.forward(c, joints, at, seed)
    }
    fn motion_block(
        &self,
        c: &[f64],
        joints: &[f64],
        pose: &Pose,
        at: &Conditions,
        out: &mut MotionBlock,
    ) -> Result<(), KinematicsError> {
        self.inner.motion_block(c, joints, pose, at, out)
    }
}
