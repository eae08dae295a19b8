//! Effects on the measurement, as parameters of the measurement.

use std::sync::Arc;

use nalgebra::{DMatrix, Matrix6xX, Rotation3, Vector6};

use crate::conditions::Conditions;
use crate::effect::context::Home;
use crate::effect::{ActiveEffect, ActsOn, EffectContext, Environment, Perturbation, Site};
use crate::measurement::{Dataset, Frames, MeasurementModel, PointReading, RowKind, Rows, Sample, TargetFrame};
use crate::mechanism::{GeometryError, Mechanism, ParameterSpec};
use crate::pose::Pose;

/// A measurement through an instrument that drifts, steps or sags.
///
/// Its own parameters are those of the measurement behind it, then those of the effects.
#[derive(Debug)]
pub struct WithInstrumentEffects {
    inner: Arc<dyn MeasurementModel>,
    mechanism: Box<dyn Mechanism>,
    environment: Arc<Environment>,
    home: Home,
    effects: Vec<ActiveEffect>,
    specs: Vec<ParameterSpec>,
    joint_motion: Matrix6xX<f64>,
}

impl WithInstrumentEffects {
    /// The data seen through those of the effects that act on the measurement; unchanged if there are none.
    /// `mechanism` is the one without effects.
    ///
    /// # Errors
    /// [`GeometryError`] if the mechanism cannot be copied.
    pub fn wrap(
        data: &Dataset,
        mechanism: &dyn Mechanism,
        environment: &Arc<Environment>,
        effects: &[ActiveEffect],
    ) -> Result<Dataset, GeometryError> {
        let effects: Vec<ActiveEffect> =
            effects.iter().filter(|e| e.effect.acts_on() == ActsOn::Measurement).cloned().collect();
        if effects.is_empty() {
            return Ok(data.clone());
        }
        let copy = mechanism.with_values(mechanism.values(), mechanism.home())?;
        let home = Home::of(mechanism, environment);
        let inner = Arc::clone(data.model());
        let mut specs = inner.nuisance_parameters().to_vec();
        let context = EffectContext::with_home(mechanism, environment, home.clone());
        effects.iter().for_each(|e| specs.extend(e.specs(&context)));
        let joint_motion = Matrix6xX::zeros(mechanism.joints().len());
        let model =
            Self { inner, mechanism: copy, environment: Arc::clone(environment), home, effects, specs, joint_motion };
        Ok(data.with_model(Arc::new(model)))
    }

    /// Motion of the reading per unit of each parameter of the effects.
    fn units(&self, sample: &Sample, pose: &Pose) -> Vec<Vector6<f64>> {
        let context = EffectContext::with_home(self.mechanism.as_ref(), &self.environment, self.home.clone());
        let Sample { joints, conditions, .. } = sample;
        let (values, joint_motion) = (self.mechanism.values(), &self.joint_motion);
        let site = Site { context: &context, values, joints, pose, conditions, joint_motion };
        Perturbation::per_unit(&self.effects, &site).iter().map(|p| p.pose).collect()
    }
}

/// Where an instrument with these effects sees the platform. Effects on the mechanism are left out.
pub fn seen(
    effects: &[ActiveEffect],
    context: &EffectContext<'_>,
    joints: &[f64],
    pose: &Pose,
    conditions: &Conditions,
) -> Pose {
    let joint_motion = Matrix6xX::zeros(joints.len());
    let values = context.mechanism.values();
    let site = Site { context, values, joints, pose, conditions, joint_motion: &joint_motion };
    let mut out = Perturbation::sized(values.len(), joints.len());
    for effect in effects.iter().filter(|e| e.effect.acts_on() == ActsOn::Measurement) {
        effect.effect.perturb(&effect.values, &effect.at, &site, &mut out);
    }
    pose.moved(&out.pose)
}

/// Rounds in which a pose is found from what is seen; the motions are micrometres, so that three are enough.
const ROUNDS: usize = 10;

/// Where the platform must be to be seen at a pose.
pub fn to_be_seen_at(
    effects: &[ActiveEffect],
    context: &EffectContext<'_>,
    joints: &[f64],
    pose: &Pose,
    conditions: &Conditions,
) -> Pose {
    let mut at = *pose;
    for _ in 0..ROUNDS {
        let motion = at.motion_to(&seen(effects, context, joints, &at, conditions));
        at = Pose {
            position: pose.position - motion.fixed_rows::<3>(0),
            rotation: Rotation3::from_scaled_axis(-motion.fixed_rows::<3>(3)) * pose.rotation,
        };
    }
    at
}

impl MeasurementModel for WithInstrumentEffects {
    fn describe(&self) -> String {
        let names: Vec<String> = self.effects.iter().map(ActiveEffect::label).collect();
        format!("{} seen through {}", self.inner.describe(), names.join(", "))
    }

    fn samples(&self) -> usize {
        self.inner.samples()
    }

    fn rows(&self, sample: usize) -> Vec<RowKind> {
        self.inner.rows(sample)
    }

    fn row_of_each(&self, sample: usize) -> Vec<Option<usize>> {
        self.inner.row_of_each(sample)
    }

    fn platform_motion(&self, own: &[f64], pose: &Pose, frames: &Frames) -> Option<DMatrix<f64>> {
        let of_inner = self.inner.nuisance_parameters().len();
        let motion = self.inner.platform_motion(&own[..of_inner], pose, frames)?;
        Some(motion.resize_horizontally(own.len(), 0.0))
    }

    fn nuisance_parameters(&self) -> &[ParameterSpec] {
        &self.specs
    }

    fn start(&self, poses: &[Option<Pose>], frames: &Frames) -> Vec<f64> {
        let mut start = self.inner.start(poses, frames);
        start.extend(self.effects.iter().flat_map(|e| &e.values));
        start
    }

    fn evaluate(&self, index: usize, sample: &Sample, pose: &Pose, frames: &Frames, own: &[f64], out: &mut Rows) {
        let first = self.inner.nuisance_parameters().len();
        let (inner, theta) = own.split_at(first);
        let units = self.units(sample, pose);
        let motion = units.iter().zip(theta).fold(Vector6::zeros(), |sum: Vector6<f64>, (u, t)| sum + u * *t);
        let mut rows = Rows::sized(out.residual.len(), first);
        self.inner.evaluate(index, sample, &pose.moved(&motion), frames, inner, &mut rows);
        for (k, unit) in units.iter().enumerate() {
            out.own.set_column(first + k, &(&rows.motion * unit));
        }
        out.own.columns_mut(0, first).copy_from(&rows.own);
        out.residual = rows.residual;
        out.motion = rows.motion;
    }

    fn covariance(&self, sample: usize, frames: &Frames) -> DMatrix<f64> {
        self.inner.covariance(sample, frames)
    }

    fn rigid_pose(&self, sample: usize) -> Option<Pose> {
        self.inner.rigid_pose(sample)
    }

    fn coordinates(&self, sample: usize) -> Option<[f64; 6]> {
        self.inner.coordinates(sample)
    }

    fn target_frame(&self) -> TargetFrame {
        self.inner.target_frame()
    }

    fn points(&self, sample: usize) -> Vec<PointReading> {
        self.inner.points(sample)
    }

    fn point(&self, sample: usize) -> Option<PointReading> {
        self.inner.point(sample)
    }
}
