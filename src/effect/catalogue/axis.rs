//! Axes of a positioner in pose space, whose joints are the commanded coordinates of the pose.
//!
//! A stage moves by 1e-5 to 1e-3 too far, its screw wobbles by 1 to 10 µm once per turn, its nut has a play of 1 to 20 µm.
//! Which of the six coordinates it is is tried out. Confused with: a wrong scale of the instrument along that axis, which
//! is the same thing in the readings; check it against a gauge before the controller is changed.

use std::f64::consts::TAU;

use super::{describe, of_legs};
use crate::conditions::{APPROACH_LEG, LENGTH_LEG};
use crate::effect::{AvailableData, Effect, EffectContext, EffectParameter, Perturbation, Scan, ScanPoint, Site};
use crate::units::Dimension;

fn needs_pose_space(context: &EffectContext<'_>) -> Vec<String> {
    if context.is_pose_space() { Vec::new() } else { vec!["a mechanism of type \"pose\"".into()] }
}

/// A parameter that is a length or an angle: the first joint's dimension, as for all effects on one joint.
fn coordinate(context: &EffectContext<'_>, name: &str, scale: f64) -> EffectParameter {
    EffectParameter::new(name, context.mechanism.joints()[0].dimension, scale)
}

/// One coordinate moves by a factor too far: `Δ = k (h - h₀)`.
#[derive(Clone, Copy, Debug)]
pub struct AxisScale;

impl Effect for AxisScale {
    describe!(
        "axis.scale",
        "one commanded coordinate has a wrong scale: a screw lead, an encoder scale, or that of the instrument",
        "compare the scale of that axis and of the instrument with a gauge, and enter the factor in the controller"
    );

    fn missing(&self, context: &EffectContext<'_>, _available: &AvailableData) -> Vec<String> {
        needs_pose_space(context)
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        vec![EffectParameter::new("scale", Dimension::None, 3e-4)]
    }

    fn scan(&self, _setting: &EffectContext<'_>, _recorded: &AvailableData) -> Scan {
        Scan::Legs
    }

    fn covariates(&self, at: &ScanPoint) -> Vec<String> {
        of_legs(LENGTH_LEG, at)
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        if let Some(k) = at.leg {
            out.joints[k] += theta[0] * (site.joints[k] - site.context.home_joints()[k]);
        }
    }
}

/// The screw of one coordinate wobbles: `Δ = A sin(2πh/p) + B cos(2πh/p)`. Of the coordinates that are lengths.
#[derive(Clone, Copy, Debug)]
pub struct AxisCyclic;

impl Effect for AxisCyclic {
    describe!(
        "axis.cyclic",
        "the screw of one coordinate wobbles: its error repeats with every turn",
        "compensate the wave in the controller, or read that axis with a linear encoder"
    );

    fn missing(&self, context: &EffectContext<'_>, _available: &AvailableData) -> Vec<String> {
        let mut missing = needs_pose_space(context);
        if context.environment.screw_pitch.is_none() {
            missing.push("[actuator] screw_pitch".into());
        }
        missing
    }

    fn parameters(&self, context: &EffectContext<'_>) -> Vec<EffectParameter> {
        vec![coordinate(context, "sin", 5e-6), coordinate(context, "cos", 5e-6)]
    }

    fn scan(&self, _setting: &EffectContext<'_>, _recorded: &AvailableData) -> Scan {
        Scan::Legs
    }

    fn covariates(&self, at: &ScanPoint) -> Vec<String> {
        of_legs(LENGTH_LEG, at)
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let (Some(k), Some(pitch)) = (at.leg, site.context.environment.screw_pitch) else { return };
        let is_length = site.context.mechanism.joints().get(k).is_some_and(|j| j.dimension == Dimension::Length);
        if is_length {
            let (s, c) = (TAU * site.joints[k] / pitch).sin_cos();
            out.joints[k] += theta[0] * s + theta[1] * c;
        }
    }
}

/// One coordinate has play that shows by the direction of approach: `Δ = ½ β sgn(h - h_before)`.
#[derive(Clone, Copy, Debug)]
pub struct AxisBacklash;

impl Effect for AxisBacklash {
    describe!(
        "axis.backlash",
        "one coordinate stops elsewhere when it is approached from the other side: play in its nut or gear",
        "approach every pose from the same side along that axis, preload it, or correct for the direction of the move"
    );

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        let mut missing = needs_pose_space(context);
        if available.moves.last().is_none_or(|most| *most == 0.0) {
            missing.push("moves from one row to the next".into());
        }
        missing
    }

    fn parameters(&self, context: &EffectContext<'_>) -> Vec<EffectParameter> {
        vec![coordinate(context, "play", 5e-6)]
    }

    fn scan(&self, _setting: &EffectContext<'_>, _recorded: &AvailableData) -> Scan {
        Scan::Legs
    }

    fn covariates(&self, at: &ScanPoint) -> Vec<String> {
        of_legs(APPROACH_LEG, at)
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let (Some(k), Some(before)) = (at.leg, &site.conditions.previous_joints) else { return };
        let moved = site.joints[k] - before[k];
        if moved != 0.0 {
            out.joints[k] += 0.5 * theta[0] * moved.signum();
        }
    }
}
