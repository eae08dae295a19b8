//! A mechanism around another one.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use paracal::conditions::Conditions;
use paracal::mechanism::{
    Extension, GeometryError, JointSpec, KinematicsError, Linearization, Mechanism, MotionBlock, ParameterSpec,
};
use paracal::pose::Pose;

/// Another mechanism under another name, which counts how often its forward kinematics is asked for.
#[derive(Debug)]
pub struct Wrapped {
    inner: Box<dyn Mechanism>,
    forwards: Arc<AtomicUsize>,
}

impl Wrapped {
    pub fn around(inner: Box<dyn Mechanism>) -> Self {
        Self { inner, forwards: Arc::default() }
    }

    /// Forward kinematics of this mechanism and of all that were made of it.
    pub fn forwards(&self) -> usize {
        self.forwards.load(Ordering::Relaxed)
    }
}

impl Mechanism for Wrapped {
    fn name(&self) -> &str {
        "renamed"
    }
    fn parameters(&self) -> &[ParameterSpec] {
        self.inner.parameters()
    }
    fn values(&self) -> &[f64] {
        self.inner.values()
    }
    fn with_values(&self, c: &[f64], home: Pose) -> Result<Box<dyn Mechanism>, GeometryError> {
        let forwards = Arc::clone(&self.forwards);
        Ok(Box::new(Self { inner: self.inner.with_values(c, home)?, forwards }))
    }
    fn joints(&self) -> &[JointSpec] {
        self.inner.joints()
    }
    fn home(&self) -> Pose {
        self.inner.home()
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
