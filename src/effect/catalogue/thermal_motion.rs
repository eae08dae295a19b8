//! Rigid motions that follow a temperature: of the pose in pose space, and of the frame of the instrument.
//!
//! Both are six values per kelvin of one temperature, and which one is tried out; the first is the machine's and can be
//! commanded away, the second is seen only.

use nalgebra::Vector3;

use super::{describe, each_alone, move_frame};
use crate::conditions::{TEMP_LEG, TEMP_LEGS, of_leg};
use crate::effect::{
    ActsOn, AvailableData, Effect, EffectContext, EffectParameter, Perturbation, Scan, ScanPoint, Site,
};
use crate::units::Dimension;

/// Three shifts and three turns per kelvin.
fn rigid() -> Vec<EffectParameter> {
    let of = |(k, name): (usize, &&str)| match k {
        0..3 => EffectParameter::new(*name, Dimension::LengthPerKelvin, 1e-5),
        _ => EffectParameter::new(*name, Dimension::AnglePerKelvin, 1e-5),
    };
    ["x", "y", "z", "rx", "ry", "rz"].iter().enumerate().map(of).collect()
}

/// The motion at the temperature of a sample; none where it was not recorded.
fn motion(theta: &[f64], at: &ScanPoint, site: &Site<'_>) -> [f64; 6] {
    let t = at.covariate.as_ref().and_then(|c| site.temperature_at(c, at)).unwrap_or(0.0);
    std::array::from_fn(|k| theta[k] * t)
}

/// Nothing, or what is missing of temperatures that a rigid motion may follow.
fn needs(right_kind: bool, kind: &str, temperatures: &[String]) -> Vec<String> {
    let mut missing = Vec::new();
    if !right_kind {
        missing.push(kind.to_owned());
    }
    if temperatures.is_empty() {
        missing.push("a column temp_…".into());
    }
    missing
}

/// In pose space, the six coordinates move in proportion to a temperature. Which temperature is tried out.
#[derive(Clone, Copy, Debug)]
pub struct ThermalPose;

impl Effect for ThermalPose {
    describe!(
        "thermal.pose",
        "the pose moves in proportion to a temperature",
        "add the temperature to the look-up table"
    );

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        let temperatures = available.temperatures(&context.environment.condition_kinds);
        needs(context.is_pose_space(), "a mechanism of type \"pose\"", &temperatures)
    }

    fn may_lag(&self) -> bool {
        true
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        rigid()
    }

    fn often_alone(&self, _setting: &EffectContext<'_>) -> Vec<Vec<f64>> {
        each_alone(6)
    }

    fn scan(&self, context: &EffectContext<'_>, available: &AvailableData) -> Scan {
        Scan::Covariates(available.temperatures(&context.environment.condition_kinds))
    }

    fn covariates(&self, at: &ScanPoint) -> Vec<String> {
        at.covariate.iter().cloned().collect()
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let moved = motion(theta, at, site);
        for (delta, v) in out.joints.iter_mut().zip(moved) {
            *delta += v;
        }
    }
}

/// The frame of the instrument follows a temperature: a rigid motion of the readings about the origin of the base, in
/// proportion to it. Which temperature is tried out; those of the legs one by one are not, where their mean is known.
/// A stand of steel of 1 m rises by 12 µm/K. Confused with: growth of all legs, of the base or of the platform, which move a
/// platform near home nearly along one direction, in a small workspace beyond what any number of poses tells apart. The
/// remedies differ: what only the instrument sees is not to be compensated.
#[derive(Clone, Copy, Debug)]
pub struct ThermalFrame;

impl ThermalFrame {
    /// The temperatures that a frame may follow.
    fn temperatures(context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        let kinds = &context.environment.condition_kinds;
        let mut names = available.temperatures(kinds);
        let of_all_legs = (0..context.joints()).all(|leg| available.has(&of_leg(TEMP_LEG, leg)));
        if of_all_legs || available.has(TEMP_LEGS) {
            names.retain(|name| kinds.leg_of(name).is_none());
            if !available.has(TEMP_LEGS) {
                names.push(TEMP_LEGS.into());
            }
        }
        names
    }
}

impl Effect for ThermalFrame {
    describe!(
        "thermal.frame",
        "the frame of the instrument moves with a temperature: its stand, or what carries the base, expands",
        "measure reference points on the base as the temperature changes, or keep the stand of the instrument at one \
         temperature; commands cannot correct what only the instrument sees"
    );

    fn acts_on(&self) -> ActsOn {
        ActsOn::Measurement
    }

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        let kind = "joints other than the coordinates of the pose";
        needs(!context.is_pose_space(), kind, &Self::temperatures(context, available))
    }

    fn may_lag(&self) -> bool {
        true
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        rigid()
    }

    fn often_alone(&self, _setting: &EffectContext<'_>) -> Vec<Vec<f64>> {
        each_alone(6)
    }

    fn scan(&self, context: &EffectContext<'_>, available: &AvailableData) -> Scan {
        Scan::Covariates(Self::temperatures(context, available))
    }

    fn covariates(&self, at: &ScanPoint) -> Vec<String> {
        at.covariate.iter().cloned().collect()
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let [x, y, z, rx, ry, rz] = motion(theta, at, site);
        move_frame(Vector3::new(x, y, z), Vector3::new(rx, ry, rz), site, out);
    }
}
