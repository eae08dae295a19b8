//! The catalogue of causes.
//!
//! Each file states the equation, the usual size, what the effect needs and what it is confused with. `Δᵢ` is the true
//! coordinate of joint `i` minus the commanded one, `Lᵢ` the commanded coordinate and `L₀ᵢ` that at home.
//!
//! | name | equation | parameters |
//! |---|---|---|
//! | `thermal.legs.uniform` | `Δᵢ = α Lᵢ (T̄ - T₀)` | expansion |
//! | `thermal.legs.individual` | `Δᵢ = α Lᵢ (Tᵢ - T₀)` | expansion |
//! | `thermal.leg.single` | as above, for one leg `k` only | expansion |
//! | `thermal.platform`, `thermal.base` | `δaᵢ = α (T_p - T₀) aᵢ`, `δbᵢ = α (T_b - T₀) bᵢ` | expansion |
//! | `thermal.gradient` | `δbᵢ = α (T₀' + ½ G·bᵢ) bᵢ` with `T₀' + G·b` through three or more sensors | expansion |
//! | `thermal.pose` | `δq = v (T - T₀)` in pose space | six |
//! | `thermal.frame` | `δt = v (T - T₀)`, `δω = w (T - T₀)`, seen | six |
//! | `scale.common`, `scale.per_leg` | `Δᵢ = k (Lᵢ - L₀ᵢ)`, `Δᵢ = kᵢ (Lᵢ - L₀ᵢ)` | one, or one per leg |
//! | `length.quadratic` | `Δᵢ = cᵢ (Lᵢ - L₀ᵢ)²` | one per leg |
//! | `cyclic.pitch` | `Δᵢ = Aᵢ sin(2πLᵢ/p) + Bᵢ cos(2πLᵢ/p)` | two per leg |
//! | `backlash` | `Δᵢ = ½ βᵢ sgn(Lᵢ - Lᵢ,before)` | one per leg |
//! | `hysteresis.play` | `Δᵢ = P(Lᵢ) - Lᵢ`, `P` the play operator | one per leg and width |
//! | `compliance.gravity`, `compliance.payload` | `Δᵢ = Fᵢ/k`, `Gᵀ F = (m g, R c × m g)` | compliance 1/k |
//! | `sag.frame` | `δt = c₁ ĝ`, `δω = c₂ (ẑ × ĝ)`, seen | two |
//! | `sag.platform` | `δaᵢ = (κ₁ cos 2φᵢ + κ₂ sin 2φᵢ) ĝ_z e_z` | two |
//! | `sag.linear` | `δq = G ĝ` in pose space | 6 × 3 |
//! | `joint.pivot_shift` | `Δᵢ = κ ϑᵢ²` | κ |
//! | `joint.screw_coupling` | `Δᵢ = κ ψᵢ`, `ψᵢ` the twist of the leg | κ |
//! | `drift.frame`, `drift.leg` | `δq = d τ`, seen; `Δₖ = d τ`, `τ` from 0 to 1 through the run | six; one |
//! | `step.frame`, `step.leg` | as the drifts, a constant from one row on | six; one |
//! | `instrument.scale`, `instrument.rotation_gain` | `δt = diag(k) t`; `δω = E diag(k) (α - α₀)`, seen | three |
//! | `instrument.skew` | `δx = s₁ y + s₂ z`, `δy = s₃ z`, seen | three |
//! | `axis.scale`, `axis.cyclic`, `axis.backlash` | as `scale.per_leg`, `cyclic.pitch` and `backlash`, for one coordinate of a pose | one; two; one |
//!
//! Misplaced trackers, misplaced targets and offsets of legs are not in the catalogue: the kinematic parameters
//! contain them to rounding (18 of the 42 directions), and a diagnosis that finds them is wrong.
//!
//! A new effect is a type in the file of its group and a line in the list below; its conditions are entries of the
//! [table of conditions](crate::conditions).

mod axis;
mod gravity;
mod instrument;
mod joints;
mod length;
mod thermal;
mod thermal_motion;
mod time;

use std::sync::Arc;

pub use axis::{AxisBacklash, AxisCyclic, AxisScale};
pub use gravity::{ComplianceGravity, CompliancePayload, SagFrame, SagLinear, SagPlatform};
pub use instrument::{InstrumentRotationGain, InstrumentScale, InstrumentSkew};
pub use joints::{Backlash, PivotShift, Play, ScrewCoupling};
pub use length::{CyclicPitch, LengthQuadratic, ScaleCommon, ScalePerLeg};
pub use thermal::{
    ThermalBase, ThermalGradient, ThermalLegSingle, ThermalLegsIndividual, ThermalLegsUniform, ThermalPlatform,
};
pub use thermal_motion::{ThermalFrame, ThermalPose};
pub use time::{Course, FrameMoves, LegMoves};

use nalgebra::{Vector3, Vector6};

use super::Effect;
use crate::conditions::of_leg;

/// Effects by name: those that are looked for in data and that mechanism files may state. Copies share the effects.
#[derive(Clone, Debug)]
pub struct Catalogue {
    effects: Vec<Arc<dyn Effect>>,
}

impl Default for Catalogue {
    fn default() -> Self {
        Self::standard()
    }
}

impl Catalogue {
    /// The effects of this crate.
    pub fn standard() -> Self {
        Self { effects: standard() }
    }

    /// One effect more; it replaces the one of its name.
    #[must_use]
    pub fn with(mut self, effect: impl Effect + 'static) -> Self {
        self.effects.retain(|other| other.name() != effect.name());
        self.effects.push(Arc::new(effect));
        self
    }

    /// The effect of a name.
    pub fn get(&self, name: &str) -> Option<&Arc<dyn Effect>> {
        self.iter().find(|effect| effect.name() == name)
    }

    /// The effects, in the order in which they were added: of the standard ones, simpler ones first.
    pub fn iter(&self) -> std::slice::Iter<'_, Arc<dyn Effect>> {
        self.effects.iter()
    }

    /// Number of effects.
    pub fn len(&self) -> usize {
        self.effects.len()
    }

    /// True without effects.
    pub fn is_empty(&self) -> bool {
        self.effects.is_empty()
    }
}

impl<'a> IntoIterator for &'a Catalogue {
    type Item = &'a Arc<dyn Effect>;
    type IntoIter = std::slice::Iter<'a, Arc<dyn Effect>>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

/// A catalogue of these effects alone.
impl FromIterator<Arc<dyn Effect>> for Catalogue {
    fn from_iter<I: IntoIterator<Item = Arc<dyn Effect>>>(effects: I) -> Self {
        Self { effects: effects.into_iter().collect() }
    }
}

fn standard() -> Vec<Arc<dyn Effect>> {
    vec![
        Arc::new(ThermalLegsUniform),
        Arc::new(ThermalLegsIndividual),
        Arc::new(ThermalLegSingle),
        Arc::new(ThermalPlatform),
        Arc::new(ThermalBase),
        Arc::new(ThermalGradient),
        Arc::new(ThermalPose),
        Arc::new(ThermalFrame),
        Arc::new(ScaleCommon),
        Arc::new(ScalePerLeg),
        Arc::new(LengthQuadratic),
        Arc::new(CyclicPitch),
        Arc::new(Backlash),
        Arc::new(Play),
        Arc::new(ComplianceGravity),
        Arc::new(CompliancePayload),
        Arc::new(SagFrame),
        Arc::new(SagPlatform),
        Arc::new(SagLinear),
        Arc::new(PivotShift),
        Arc::new(ScrewCoupling),
        Arc::new(FrameMoves(Course::Drift)),
        Arc::new(LegMoves(Course::Drift)),
        Arc::new(FrameMoves(Course::Step)),
        Arc::new(LegMoves(Course::Step)),
        Arc::new(InstrumentScale),
        Arc::new(InstrumentRotationGain),
        Arc::new(InstrumentSkew),
        Arc::new(AxisScale),
        Arc::new(AxisCyclic),
        Arc::new(AxisBacklash),
    ]
}

/// Name, cause and remedy of an effect.
macro_rules! describe {
    ($name:literal, $cause:literal, $remedy:literal) => {
        fn name(&self) -> &str {
            $name
        }
        fn cause(&self) -> &str {
            $cause
        }
        fn remedy(&self) -> &str {
            $remedy
        }
    };
}
use describe;

/// A small rigid motion `(shift, turn)` of the frame of the instrument about the origin of the base, as the motion of the
/// platform that is seen. In pose space, whose positions count from anywhere, turns have no arm.
fn move_frame(shift: Vector3<f64>, turn: Vector3<f64>, site: &super::Site<'_>, out: &mut super::Perturbation) {
    let arm = if site.context.is_pose_space() { Vector3::zeros() } else { site.pose.position };
    let shift = shift + turn.cross(&arm);
    out.pose += Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z);
}

/// Each of so many parameters alone, as directions.
fn each_alone(count: usize) -> Vec<Vec<f64>> {
    (0..count).map(|k| (0..count).map(|i| f64::from(u8::from(i == k))).collect()).collect()
}

/// Covariates of a stem for every leg that there may be.
fn of_legs(stem: &str, at: &super::ScanPoint) -> Vec<String> {
    match at.leg {
        Some(leg) => vec![of_leg(stem, leg)],
        None => (0..MOST_LEGS).map(|leg| of_leg(stem, leg)).collect(),
    }
}

/// More legs than any machine has.
const MOST_LEGS: usize = 12;

/// The columns of a list that were not recorded.
fn unrecorded(available: &super::AvailableData, columns: &[&str]) -> Vec<String> {
    columns.iter().filter(|c| !available.has(c)).map(|c| (*c).to_owned()).collect()
}

/// One parameter for each joint: `stem1`, `stem2`, ….
fn per_leg(
    context: &super::EffectContext<'_>,
    stem: &str,
    dimension: crate::units::Dimension,
    scale: f64,
) -> Vec<super::EffectParameter> {
    let joints = context.mechanism.joints();
    // A length means the coordinate of the joint, which may be an angle.
    let of = |leg: usize| match dimension {
        crate::units::Dimension::Length => joints[leg].dimension,
        other => other,
    };
    let parameter = |leg: usize| super::EffectParameter::new(format!("{stem}{}", leg + 1), of(leg), scale);
    (0..joints.len()).map(parameter).collect()
}
