//! Errors that repeat with the commanded joint coordinate.
//!
//! A screw lead is wrong by 50 to 500 ppm, an encoder bends by 0.01 to 0.1 µm/mm², a screw wobbles by 1 to 10 µm once per
//! turn. Scale and curvature are mostly absorbed by the kinematic parameters in a small workspace (24 to 66 % in
//! ±10 mm) and come back as errors outside of it: the gain with range is twofold to fourfold per doubling.
//! `scale.common` is the same as a wrong unit of the tracker (their columns agree to 0.999).

use std::f64::consts::TAU;

use super::{describe, of_legs, per_leg};
use crate::conditions::LENGTH_LEG;
use crate::effect::{AvailableData, Effect, EffectContext, EffectParameter, Perturbation, ScanPoint, Site};
use crate::units::Dimension;

/// Joints whose coordinates stand for something that can stretch; in pose space they are the pose itself.
fn needs_legs(context: &EffectContext<'_>) -> Vec<String> {
    if context.is_pose_space() { vec!["legs".into()] } else { Vec::new() }
}

fn own_length(at: &ScanPoint) -> Vec<String> {
    of_legs(LENGTH_LEG, at)
}

/// All joints move by a common factor too far.
#[derive(Clone, Copy, Debug)]
pub struct ScaleCommon;

impl Effect for ScaleCommon {
    describe!(
        "scale.common",
        "the length scales of the joints and of the tracker disagree by a factor",
        "check the lead of the screws and the scale of the tracker against a gauge"
    );

    fn missing(&self, context: &EffectContext<'_>, _recorded: &AvailableData) -> Vec<String> {
        needs_legs(context)
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        vec![EffectParameter::new("scale", Dimension::None, 2e-3)]
    }

    fn special_case_of(&self) -> &[&str] {
        &["scale.per_leg"]
    }

    fn covariates(&self, at: &ScanPoint) -> Vec<String> {
        own_length(at)
    }

    fn perturb(&self, theta: &[f64], _at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        for ((delta, length), home) in out.joints.iter_mut().zip(site.joints).zip(site.context.home_joints()) {
            *delta += theta[0] * (length - home);
        }
    }
}

/// Each joint has a factor of its own.
#[derive(Clone, Copy, Debug)]
pub struct ScalePerLeg;

impl Effect for ScalePerLeg {
    describe!(
        "scale.per_leg",
        "each joint has its own scale error: screw leads, encoder scales, drum radii",
        "enter the factors in the controller, or measure the leads"
    );

    fn missing(&self, context: &EffectContext<'_>, _recorded: &AvailableData) -> Vec<String> {
        needs_legs(context)
    }

    fn parameters(&self, context: &EffectContext<'_>) -> Vec<EffectParameter> {
        per_leg(context, "scale", Dimension::None, 2e-3)
    }

    fn covariates(&self, at: &ScanPoint) -> Vec<String> {
        own_length(at)
    }

    fn perturb(&self, theta: &[f64], _at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let home = site.context.home_joints();
        for (leg, k) in theta.iter().enumerate() {
            out.joints[leg] += k * (site.joints[leg] - home[leg]);
        }
    }
}

/// The reading of each joint bends.
#[derive(Clone, Copy, Debug)]
pub struct LengthQuadratic;

impl Effect for LengthQuadratic {
    describe!(
        "length.quadratic",
        "the true coordinate of a joint is not linear in the commanded one: a nonlinear encoder or screw, or a drum whose \
         radius grows as it is wound",
        "calibrate the encoders against a linear reference, or enter the curvature in the controller"
    );

    fn missing(&self, context: &EffectContext<'_>, _recorded: &AvailableData) -> Vec<String> {
        needs_legs(context)
    }

    fn parameters(&self, context: &EffectContext<'_>) -> Vec<EffectParameter> {
        match context.joints_are_lengths() {
            true => per_leg(context, "curvature", Dimension::PerLength, 5e-2),
            false => per_leg(context, "curvature", Dimension::PerAngle, 1e-4),
        }
    }

    fn covariates(&self, at: &ScanPoint) -> Vec<String> {
        own_length(at)
    }

    fn perturb(&self, theta: &[f64], _at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let home = site.context.home_joints();
        for (leg, c) in theta.iter().enumerate() {
            out.joints[leg] += c * (site.joints[leg] - home[leg]).powi(2);
        }
    }
}

/// The screws wobble once per turn.
#[derive(Clone, Copy, Debug)]
pub struct CyclicPitch;

impl Effect for CyclicPitch {
    describe!(
        "cyclic.pitch",
        "the screws wobble: the error repeats with every turn",
        "compensate the wave in the controller, or read the legs with linear encoders"
    );

    fn missing(&self, context: &EffectContext<'_>, _recorded: &AvailableData) -> Vec<String> {
        let mut missing =
            if context.joints_are_lengths() { needs_legs(context) } else { vec!["legs of variable length".into()] };
        if context.environment.screw_pitch.is_none() {
            missing.push("[actuator] screw_pitch".into());
        }
        missing
    }

    fn parameters(&self, context: &EffectContext<'_>) -> Vec<EffectParameter> {
        let mut all = per_leg(context, "sin", Dimension::Length, 5e-6);
        all.extend(per_leg(context, "cos", Dimension::Length, 5e-6));
        all
    }

    fn covariates(&self, at: &ScanPoint) -> Vec<String> {
        own_length(at)
    }

    fn perturb(&self, theta: &[f64], _at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let Some(pitch) = site.context.environment.screw_pitch else { return };
        let n = site.joints.len();
        for leg in 0..n {
            let (sin, cos) = (theta[leg], theta[n + leg]);
            if sin != 0.0 || cos != 0.0 {
                let (s, c) = (TAU * site.joints[leg] / pitch).sin_cos();
                out.joints[leg] += sin * s + cos * c;
            }
        }
    }
}
