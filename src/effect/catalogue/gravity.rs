//! Gravity and payload.
//!
//! A mirror of 500 kg on legs of 100 N/µm moves by ±10 to 20 µm over elevation; the frame of a tracker sags by 5 to 50 µm.
//! `compliance.gravity` and `sag.frame` share 99.8 % of their shape where only elevation changes: what is told apart
//! is told by a few parts in a thousand, and ties are usual.

use nalgebra::{Vector3, Vector6};

use super::{describe, move_frame, unrecorded};
use crate::conditions::{ELEVATION, PAYLOAD};
use crate::effect::{ActsOn, AvailableData, Effect, EffectContext, EffectParameter, Perturbation, ScanPoint, Site};
use crate::mechanism::Body;
use crate::units::Dimension;

/// Acceleration of gravity, m/s².
const G: f64 = 9.81;

fn gravity_missing(available: &AvailableData) -> Vec<String> {
    if available.gravity { Vec::new() } else { vec!["elevation (or gravity_x, gravity_y, gravity_z)".into()] }
}

fn elevation() -> Vec<String> {
    vec![ELEVATION.into()]
}

/// Joint displacements under a weight `force` at the platform point `place`, per unit compliance: by virtual work the
/// force of a joint is the wrench times the motion per unit of the joint, `F = J_hᵀ w`, which solves `Gᵀ F = w`.
fn loaded(site: &Site<'_>, place: &Vector3<f64>, force: &Vector3<f64>, compliance: f64, out: &mut Perturbation) {
    let moment = (site.pose.rotation * place).cross(force);
    let wrench = Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z);
    for (k, delta) in out.joints.iter_mut().enumerate() {
        *delta += compliance * site.joint_motion.column(k).dot(&wrench);
    }
}

fn compliance() -> Vec<EffectParameter> {
    vec![EffectParameter::new("compliance", Dimension::Compliance, 1e-8)]
}

/// The legs give way under the weight of the platform.
#[derive(Clone, Copy, Debug)]
pub struct ComplianceGravity;

impl Effect for ComplianceGravity {
    describe!(
        "compliance.gravity",
        "the legs deflect under the weight of the platform as the direction of gravity changes",
        "correct for elevation, or stiffen the legs and their joints"
    );

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        let mut missing = gravity_missing(available);
        let s = context.environment;
        let known =
            [("[platform] mass_kg", s.mass.is_some()), ("[platform] centre_of_mass", s.centre_of_mass.is_some())];
        missing.extend(known.iter().filter(|(_, known)| !known).map(|(name, _)| (*name).to_owned()));
        if context.is_pose_space() {
            missing.push("legs".into());
        }
        missing
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        compliance()
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        elevation()
    }

    fn perturb(&self, theta: &[f64], _at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let s = site.context.environment;
        if let (Some(gravity), Some(mass), Some(centre)) = (site.conditions.gravity, s.mass, s.centre_of_mass) {
            loaded(site, &centre, &(gravity * (mass * G)), theta[0], out);
        }
    }
}

/// The legs give way under a payload.
#[derive(Clone, Copy, Debug)]
pub struct CompliancePayload;

impl Effect for CompliancePayload {
    describe!(
        "compliance.payload",
        "the legs deflect under the payload",
        "correct for the payload, or stiffen the legs and their joints"
    );

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        let mut missing = gravity_missing(available);
        missing.extend(unrecorded(available, &[PAYLOAD]));
        if context.environment.payload_centre.is_none() {
            missing.push("[platform] payload_centre".into());
        }
        if context.is_pose_space() {
            missing.push("legs".into());
        }
        missing
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        compliance()
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        vec![PAYLOAD.into(), ELEVATION.into()]
    }

    fn perturb(&self, theta: &[f64], _at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let load = site.conditions.get(PAYLOAD);
        let centre = site.context.environment.payload_centre;
        if let (Some(gravity), Some(mass), Some(centre)) = (site.conditions.gravity, load, centre) {
            loaded(site, &centre, &(gravity * (mass * G)), theta[0], out);
        }
    }
}

/// The frame of the instrument sags against the base.
#[derive(Clone, Copy, Debug)]
pub struct SagFrame;

impl Effect for SagFrame {
    describe!(
        "sag.frame",
        "the frame of the base or of the instrument sags as the direction of gravity changes",
        "measure reference points on the base at each elevation; commands cannot correct what only the instrument sees"
    );

    fn acts_on(&self) -> ActsOn {
        ActsOn::Measurement
    }

    fn missing(&self, _setting: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        gravity_missing(available)
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        vec![
            EffectParameter::new("shift", Dimension::Length, 2e-5),
            EffectParameter::new("tilt", Dimension::Angle, 2e-5),
        ]
    }

    fn special_case_of(&self) -> &[&str] {
        &["sag.linear"]
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        elevation()
    }

    fn perturb(&self, theta: &[f64], _at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let Some(gravity) = site.conditions.gravity else { return };
        move_frame(gravity * theta[0], Vector3::z().cross(&gravity) * theta[1], site, out);
    }
}

/// The platform bends astigmatically under its own weight.
#[derive(Clone, Copy, Debug)]
pub struct SagPlatform;

impl Effect for SagPlatform {
    describe!(
        "sag.platform",
        "the platform bends into a saddle under its own weight",
        "stiffen the platform, or correct for elevation"
    );

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        let mut missing = gravity_missing(available);
        if !context.has_points(Body::Platform) {
            missing.push("platform points among the parameters".into());
        }
        missing
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        vec![EffectParameter::new("cos", Dimension::Length, 1e-5), EffectParameter::new("sin", Dimension::Length, 1e-5)]
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        elevation()
    }

    fn perturb(&self, theta: &[f64], _at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let Some(gravity) = site.conditions.gravity else { return };
        let points = Body::Platform.points(site.context.mechanism, site.values);
        for (k, spec) in site.context.mechanism.parameters().iter().enumerate() {
            let Some((leg, 2)) = Body::Platform.coordinate(spec.role) else { continue };
            let Some((_, a)) = points.iter().find(|(l, _)| *l == leg) else { continue };
            let (sin, cos) = (2.0 * a.y.atan2(a.x)).sin_cos();
            out.parameters[k] += (theta[0] * cos + theta[1] * sin) * gravity.z;
        }
    }
}

/// In pose space, each coordinate is linear in the direction of gravity.
#[derive(Clone, Copy, Debug)]
pub struct SagLinear;

impl Effect for SagLinear {
    describe!(
        "sag.linear",
        "structure and positioner sag in proportion to the components of gravity",
        "correct with a table of the six coordinates against elevation"
    );

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        let mut missing = gravity_missing(available);
        if !context.is_pose_space() {
            missing.push("a mechanism of type \"pose\"".into());
        }
        missing
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        let mut all = Vec::new();
        for (k, row) in ["x", "y", "z", "rx", "ry", "rz"].iter().enumerate() {
            for column in ["x", "y", "z"] {
                let (dimension, scale) = if k < 3 { (Dimension::Length, 1e-4) } else { (Dimension::Angle, 1e-4) };
                all.push(EffectParameter::new(format!("{row}_g{column}"), dimension, scale));
            }
        }
        all
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        elevation()
    }

    fn perturb(&self, theta: &[f64], _at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let Some(gravity) = site.conditions.gravity else { return };
        for (delta, row) in out.joints.iter_mut().zip(theta.chunks_exact(3)) {
            *delta += row[0] * gravity.x + row[1] * gravity.y + row[2] * gravity.z;
        }
    }
}
