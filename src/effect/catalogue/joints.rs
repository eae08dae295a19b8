//! Play and imperfect joints.
//!
//! Backlash of 1 to 20 µm shows by the direction of approach; a flexure whose centre wanders, by 1 to 10 mm times the
//! square of its angle. A pivot shift is absorbed to 69 % in ±10 mm and wrong by five times the noise in twice
//! that range.

use super::{describe, of_legs, per_leg};
use crate::conditions::APPROACH_LEG;
use crate::effect::{AvailableData, Effect, EffectContext, EffectParameter, Perturbation, Scan, ScanPoint, Site};
use crate::mechanism::Body;
use crate::pose::rotation_vector;
use crate::units::Dimension;

fn approaches(at: &ScanPoint) -> Vec<String> {
    of_legs(APPROACH_LEG, at)
}

/// Play that shows by the direction of approach.
#[derive(Clone, Copy, Debug)]
pub struct Backlash;

impl Effect for Backlash {
    describe!(
        "backlash",
        "a joint stops at a different position when approached from the other side: play in nuts, gears or joints",
        "approach every pose from the same side, preload the joints, or correct for the direction of the move"
    );

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        let mut missing = if context.is_pose_space() { vec!["legs".into()] } else { Vec::new() };
        if available.moves.last().is_none_or(|most| *most == 0.0) {
            missing.push("moves from one row to the next".into());
        }
        missing
    }

    fn parameters(&self, context: &EffectContext<'_>) -> Vec<EffectParameter> {
        per_leg(context, "play", Dimension::Length, 5e-6)
    }

    fn covariates(&self, at: &ScanPoint) -> Vec<String> {
        approaches(at)
    }

    fn perturb(&self, theta: &[f64], _at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let Some(before) = &site.conditions.previous_joints else { return };
        for (leg, play) in theta.iter().enumerate() {
            let moved = site.joints[leg] - before[leg];
            if moved != 0.0 {
                out.joints[leg] += 0.5 * play * moved.signum();
            }
        }
    }
}

/// Widths of play that are tried, m.
const WIDTHS: [f64; 4] = [5e-6, 2e-5, 8e-5, 3e-4];
/// Part of the moves that must be shorter than a width, or else play of that width is backlash.
const SHORT: f64 = 0.1;

/// Play with a memory: a joint follows its command only at the ends of its play, so that moves shorter than the play
/// are lost. After long moves it is backlash and nothing else; it is tested where some moves are shorter.
///
/// The play operator of width `w` is not linear in `w`. Widths are tried out; the parameter is the part of the lost way
/// that the joint really loses, 1 for an ideal play of that width.
#[derive(Clone, Copy, Debug)]
pub struct Play;

impl Play {
    /// Widths that the moves tell from backlash.
    fn widths(available: &AvailableData) -> Vec<f64> {
        WIDTHS.into_iter().filter(|w| available.shorter_moves(*w) > SHORT).collect()
    }

    /// What remains of the way through the play at a row of the run: `P(L) - L`.
    fn lost(history: &[Vec<f64>], row: usize, leg: usize, home: f64, width: f64) -> f64 {
        let follow = |at: f64, command: f64| at.clamp(command - 0.5 * width, command + 0.5 * width);
        let rows = &history[..=row.min(history.len().saturating_sub(1))];
        let end = rows.iter().fold(home, |at, joints| follow(at, joints[leg]));
        end - rows.last().map_or(home, |joints| joints[leg])
    }
}

impl Effect for Play {
    describe!(
        "hysteresis.play",
        "joints do not follow moves shorter than their play, and lag behind longer ones",
        "preload the joints, or approach every pose with a long move from the same side"
    );

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        let mut missing = Vec::new();
        if context.is_pose_space() || !context.joints_are_lengths() {
            missing.push("legs of variable length".into());
        }
        if !available.run {
            missing.push("the complete history of commands".into());
        } else if Self::widths(available).is_empty() {
            missing.push("moves shorter than the play (without them it looks like backlash)".into());
        }
        missing
    }

    fn parameters(&self, context: &EffectContext<'_>) -> Vec<EffectParameter> {
        per_leg(context, "part", Dimension::None, 1.0)
    }

    fn scan(&self, _setting: &EffectContext<'_>, available: &AvailableData) -> Scan {
        Scan::Covariates(Self::widths(available).into_iter().map(|w| format!("{:.0}um", 1e6 * w)).collect())
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        Vec::new()
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let Some(run) = &site.conditions.run else { return };
        let width = at.covariate.as_ref().and_then(|w| w.strip_suffix("um")?.parse::<f64>().ok());
        let Some(width) = width.map(|w| 1e-6 * w) else { return };
        let home = site.context.home_joints();
        for (leg, part) in theta.iter().enumerate().filter(|(_, part)| **part != 0.0) {
            out.joints[leg] += part * Self::lost(&run.joints, run.row, leg, home[leg], width);
        }
    }
}

fn needs_points(context: &EffectContext<'_>) -> Vec<String> {
    let mechanism = context.mechanism;
    let are_legs = |body: Body| body.points(mechanism, mechanism.values()).len() == context.joints();
    let known = context.home_legs().iter().all(Option::is_some);
    if are_legs(Body::Platform) && are_legs(Body::Base) && known && context.joints_are_lengths() {
        Vec::new()
    } else {
        vec!["legs of variable length between points of both bodies".into()]
    }
}

/// The centre of a flexure wanders as it bends.
#[derive(Clone, Copy, Debug)]
pub struct PivotShift;

impl Effect for PivotShift {
    describe!(
        "joint.pivot_shift",
        "the joint centres shift as the legs tilt: bending flexures, or universal joints whose axes do not intersect",
        "correct for the square of the tilt; without that, do not use the model far outside the calibrated range"
    );

    fn missing(&self, context: &EffectContext<'_>, _recorded: &AvailableData) -> Vec<String> {
        needs_points(context)
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        vec![EffectParameter::new("shift", Dimension::Length, 2e-2)]
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        Vec::new()
    }

    fn perturb(&self, theta: &[f64], _at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        for (leg, (now, home)) in site.legs().iter().zip(site.context.home_legs()).enumerate() {
            if let (Some(now), Some(home)) = (now, home) {
                let tilt = now.cross(home).norm().atan2(now.dot(home));
                out.joints[leg] += theta[0] * tilt * tilt;
            }
        }
    }
}

/// A leg between two universal joints twists as the platform turns, and its screw turns with it: `Δᵢ = κ ψᵢ` with `κ` the
/// lead per radian. `ψᵢ` is the turn of the platform about the leg, less the way the leg itself went.
#[derive(Clone, Copy, Debug)]
pub struct ScrewCoupling;

impl Effect for ScrewCoupling {
    describe!(
        "joint.screw_coupling",
        "a leg twists between its universal joints as the platform rotates, and its screw turns with it",
        "correct each length by the twist of its leg times the lead, or hold the screw against turning"
    );

    fn missing(&self, context: &EffectContext<'_>, _recorded: &AvailableData) -> Vec<String> {
        let mut missing = needs_points(context);
        if context.environment.screw_pitch.is_none() {
            missing.push("[actuator] screw_pitch".into());
        }
        missing
    }

    fn parameters(&self, context: &EffectContext<'_>) -> Vec<EffectParameter> {
        let lead = context.environment.screw_pitch.unwrap_or(5e-3) / std::f64::consts::TAU;
        vec![EffectParameter::new("lead", Dimension::LengthPerAngle, lead)]
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        Vec::new()
    }

    fn perturb(&self, theta: &[f64], _at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let turned = site.pose.rotation * site.context.mechanism.home().rotation.inverse();
        for (leg, (now, home)) in site.legs().iter().zip(site.context.home_legs()).enumerate() {
            let (Some(now), Some(home)) = (now, home) else { continue };
            let Some(swing) = nalgebra::Rotation3::rotation_between(home, now) else { continue };
            let twist = rotation_vector(&(turned * swing.inverse())).dot(now);
            out.joints[leg] += theta[0] * twist;
        }
    }
}
