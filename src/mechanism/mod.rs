//! Mechanisms: their parts, and how joints, parameters and pose are related.
//!
//! A parallel mechanism is a set of `m ≥ 6` **closure equations** `f(q, h, C) = 0` in the pose `q`, the joint
//! coordinates `h` and the kinematic parameters `C`. Everything else follows from their derivatives
//!
//! | symbol | derivative along | size | code |
//! |---|---|---|---|
//! | `J₁ = ∂f/∂q` | small motion `(δt, δω)` of the platform | m × 6 | [`Linearization::motion`] |
//! | `J₂ = ∂f/∂C` | parameters | m × L | [`Linearization::parameters`] |
//! | `Jⱼ = ∂f/∂h` | joints | m × n | [`Linearization::joints`] |
//! | `J_b = -J₁⁺ J₂` | motion per parameter, eq. (23) with the sign of eq. (17) | 6 × L | [`MotionBlock::parameters`] |
//!
//! The paper drops the minus between eqs. (17) and (18); taken literally its iteration diverges. Derivatives
//! are along small motions (see [`crate::pose`]); multiply by
//! [`PoseConvention::rates`](crate::pose::PoseConvention::rates) for the paper's coordinates.
//!
//! [`Mechanism`] is the trait. It does not assume six legs, prismatic joints, 42 parameters or square
//! closures: a mechanism of lower mobility states its structural constraints as further rows, a redundant one
//! has more rows than six. [`SixHardpoint`] is the paper's mechanism in closed form; [`PosePositioner`] is
//! commanded in coordinates of the pose. A consumer's own
//! mechanism states its closure and derivatives and gets forward kinematics, motion blocks and, through
//! them, identification; the suite `conformance` compares every derivative with differences.

mod characteristics;
pub mod closure;
mod core;
mod error;
pub mod kinds;
mod kinematics;
mod mirror;
mod mounted;
pub(crate) mod mounting;
mod parameter;
mod pose_positioner;
mod reach;
mod six_hardpoint;
mod six_legs;
mod six_legs_batch;
mod survey;
mod workspace;

use std::any::Any;
use std::fmt::Debug;

use nalgebra::{DMatrix, DVector, Matrix6xX, Vector3};

pub(crate) use characteristics::not_carried;
pub use characteristics::{Body, characteristic_length, condition, rigid_directions};
use characteristics::{check_held, inverse_motion};
pub use core::MechanismCore;
pub use error::{GeometryError, KinematicsError};
pub(crate) use kinematics::{carry_to_point, nearest_pose};
pub use kinematics::{
    consistent, continuation, forward_by_closure, forward_by_rows, motion_block_by_closure, motion_of_point,
};
pub use mirror::{height_over_base, mirrored_home};
pub use mounted::{Mounted, mount};
pub use parameter::{Axis, JointSpec, ParameterRole, ParameterSpec};
pub use pose_positioner::PosePositioner;
pub use reach::is_reached;
#[cfg(feature = "files")]
pub(crate) use six_hardpoint::check_distinct_anchors;
pub use six_hardpoint::{Leg, SixHardpoint};
pub use survey::Survey;
pub use workspace::Workspace;

use crate::conditions::Conditions;
use crate::pose::Pose;

/// A parallel mechanism with closure `f(q, h, C) = 0`.
///
/// Methods take the parameters `c` as an argument, in the order of [`parameters`](Self::parameters), so that
/// an identification can try values without building mechanisms. All numbers are SI.
pub trait Mechanism: Any + Debug + Send + Sync {
    /// What the mechanism keeps about itself; [`name`](Self::name), [`parameters`](Self::parameters),
    /// [`values`](Self::values), [`joints`](Self::joints) and [`home`](Self::home) read it.
    fn core(&self) -> &MechanismCore;

    /// Display name.
    fn name(&self) -> &str {
        &self.core().name
    }

    /// Name, unit, nominal value, tolerance and role of each parameter: the order of `C`, eq. (15).
    fn parameters(&self) -> &[ParameterSpec] {
        &self.core().parameters
    }

    /// The parameter values of this very mechanism (nominal or calibrated), in the order of
    /// [`parameters`](Self::parameters).
    fn values(&self) -> &[f64] {
        &self.core().values
    }

    /// Name, dimension and stroke of each joint coordinate.
    fn joints(&self) -> &[JointSpec] {
        &self.core().joints
    }

    /// The pose from which forward kinematics starts and about which the workspace lies.
    fn home(&self) -> Pose {
        self.core().home
    }

    /// A mechanism of this kind with other parameter values and another home.
    ///
    /// # Errors
    /// [`GeometryError`] if no mechanism has these values.
    fn with_values(&self, c: &[f64], home: Pose) -> Result<Box<dyn Mechanism>, GeometryError>;

    /// Number `m ≥ 6` of closure equations.
    fn equations(&self) -> usize;

    /// Which coordinates x, y, z, α, β, γ of the pose, in the mechanism's own frames, the joints control. The others
    /// follow from the closure; [`inverse`](Self::inverse) does not look at them.
    fn controlled(&self) -> [bool; 6] {
        [true; 6]
    }

    /// This mechanism as an instrument sees it: with the base at `base` in the instrument's frame and the target at
    /// `target` on the platform. `None` if the parameters can be transformed into these frames instead, because base
    /// and platform are made of their points alone.
    fn mounted(&self, _base: &Pose, _target: &Pose) -> Option<Box<dyn Mechanism>> {
        None
    }

    /// The base in the frame of the instrument and the target on the platform, for a mechanism that is
    /// [`mounted`](Self::mounted).
    fn mounting(&self) -> Option<(Pose, Pose)> {
        None
    }

    /// Where the legs meet the platform, platform frame, m: the size by which angles and lengths are compared. Those of the
    /// parameters, unless points are known that are not identified.
    fn platform_points(&self) -> Vec<Vector3<f64>> {
        Body::Platform.points(self, self.values()).into_iter().map(|(_, point)| point).collect()
    }

    /// What was put around a mechanism to make this one; `None` if nothing was. A mechanism that wraps another hands on
    /// what that one answers, or its effects are lost on the way to files and reports.
    fn extension(&self) -> Option<&dyn Extension> {
        None
    }

    /// The closure residual and its three Jacobians at a pose, in one pass.
    ///
    /// `out` has the sizes of [`Linearization::sized_for`] and is overwritten. Where there is no value the
    /// entries are NaN; callers check.
    fn linearize(&self, c: &[f64], joints: &[f64], pose: &Pose, at: &Conditions, out: &mut Linearization);

    /// Inverse kinematics (eq. 1): the joints to command for a pose.
    ///
    /// # Errors
    /// [`KinematicsError`] if the pose has no joints.
    fn inverse(&self, c: &[f64], pose: &Pose, at: &Conditions) -> Result<Vec<f64>, KinematicsError>;

    /// Forward kinematics (eqs. 4–11): the pose that the joints lead to, on the branch of `seed`.
    ///
    /// # Errors
    /// [`KinematicsError`] with numbers if the joints are out of reach, the pose is singular or a number is
    /// not finite; a result is always a root.
    fn forward(&self, c: &[f64], joints: &[f64], at: &Conditions, seed: &Pose) -> Result<Pose, KinematicsError>;

    /// Forward kinematics of many poses for the same parameters; results in order. A mechanism that solves several at once
    /// faster than one after the other says how; the roots are the same.
    fn forward_batch(&self, c: &[f64], queries: &[ForwardQuery<'_>]) -> Vec<Result<Pose, KinematicsError>> {
        queries.iter().map(|q| self.forward(c, q.joints, q.at, &q.seed)).collect()
    }

    /// True if every joint lies in its stroke; joints without a stroke always do.
    fn within_strokes(&self, joints: &[f64]) -> bool {
        self.joints().iter().zip(joints).all(|(j, v)| j.stroke.is_none_or(|[from, to]| from <= *v && *v <= to))
    }

    /// Motion of the platform per unit of each parameter (`J_b`, eq. 23) and of each joint.
    ///
    /// # Errors
    /// [`KinematicsError::Singular`] where `J₁` has no inverse.
    fn motion_block(
        &self,
        c: &[f64],
        joints: &[f64],
        pose: &Pose,
        at: &Conditions,
        out: &mut MotionBlock,
    ) -> Result<(), KinematicsError> {
        motion_block_by_closure(self, c, joints, pose, at, out)
    }
}

/// One question to [`Mechanism::forward_batch`].
#[derive(Clone, Copy, Debug)]
pub struct ForwardQuery<'a> {
    /// Joint coordinates, SI.
    pub joints: &'a [f64],
    /// Operating state.
    pub at: &'a Conditions,
    /// Where the search starts, on the branch of the answer.
    pub seed: Pose,
}

impl<'a> ForwardQuery<'a> {
    /// The pose of `joints` in the operating state `at`, on the branch of `seed`.
    pub fn new(joints: &'a [f64], at: &'a Conditions, seed: Pose) -> Self {
        Self { joints, at, seed }
    }
}

/// Something around a mechanism that has parameters of its own, such as the effects of
/// [`Extended`](crate::effect::Extended).
pub trait Extension: Any + Debug + Send + Sync {
    /// The mechanism without it.
    fn inner(&self) -> &dyn Mechanism;
}

/// Closure residual and Jacobians at one pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearization {
    /// `f` (m).
    pub residual: DVector<f64>,
    /// `J₁ = ∂f/∂(δt, δω)` (m × 6).
    pub motion: DMatrix<f64>,
    /// `J₂ = ∂f/∂C` (m × L).
    pub parameters: DMatrix<f64>,
    /// `∂f/∂h` (m × n).
    pub joints: DMatrix<f64>,
}

impl Linearization {
    /// Zeros of the sizes that `mechanism` needs.
    pub fn sized_for<M: Mechanism + ?Sized>(mechanism: &M) -> Self {
        let m = mechanism.equations();
        Self {
            residual: DVector::zeros(m),
            motion: DMatrix::zeros(m, 6),
            parameters: DMatrix::zeros(m, mechanism.parameters().len()),
            joints: DMatrix::zeros(m, mechanism.joints().len()),
        }
    }
}

/// How the platform moves when a parameter or a joint changes.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionBlock {
    /// `J_b = -J₁⁺ J₂` (6 × L): small motion `(δt, δω)` per unit of each parameter.
    pub parameters: Matrix6xX<f64>,
    /// `-J₁⁺ ∂f/∂h` (6 × n): small motion per unit of each joint.
    pub joints: Matrix6xX<f64>,
}

impl MotionBlock {
    /// Zeros of the sizes that `mechanism` needs.
    pub fn sized_for<M: Mechanism + ?Sized>(mechanism: &M) -> Self {
        Self {
            parameters: Matrix6xX::zeros(mechanism.parameters().len()),
            joints: Matrix6xX::zeros(mechanism.joints().len()),
        }
    }
}
