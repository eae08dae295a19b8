//! Instruments that read with a wrong scale, or along axes that are not square.
//!
//! A tracker whose refraction is corrected for the wrong air is off by some ppm, an interferometer with a wrong wavelength
//! likewise, a stage or an autocollimator by 1e-4 to 1e-3. Only the readings are wrong: calibrated parameters are those of
//! the mechanism, and no command compensates these effects. Axes are those of the base; angles are those in which the file
//! writes poses. Constant parts, such as the factor times the distance from the origin of the base, are taken up by the
//! parameters, which contain a misplaced tracker.
//!
//! Confused with: `scale.common`. A common factor of all position readings and one of all joints differ by the size of the
//! machine alone, which only its tolerances know; they are always reported as tied. In pose space the joints are the
//! coordinates themselves, so that scales of either are one thing: `axis.scale`.

use nalgebra::{Vector3, Vector6};

use super::{describe, each_alone};
use crate::effect::{ActsOn, AvailableData, Effect, EffectContext, EffectParameter, Perturbation, ScanPoint, Site};
use crate::pose::wrapped_angle;
use crate::units::Dimension;

/// Usual size of a wrong factor of positions: wide, so that a common factor is as soon one of the joints.
const SCALE: f64 = 1e-3;
/// Usual size of a wrong factor of angles, and of a missing right angle, rad.
const SMALL: f64 = 3e-4;

/// The commanded coordinates are those of the pose, whose scales are no other thing.
fn needs_joints(context: &EffectContext<'_>) -> Vec<String> {
    if context.is_pose_space() { vec!["joints other than the coordinates of the pose".into()] } else { Vec::new() }
}

/// And something must say where the platform is: an instrument that is moved until it touches reads nothing but zero.
fn needs_places(context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
    let mut missing = needs_joints(context);
    if available.heights_only {
        missing.push("poses or points; heights over a plane are not enough".into());
    }
    missing
}

fn parameters(names: &[&str], dimension: Dimension, scale: f64) -> Vec<EffectParameter> {
    names.iter().map(|name| EffectParameter::new(*name, dimension, scale)).collect()
}

/// The point whose position is read, in the base frame.
fn read_point(site: &Site<'_>) -> Vector3<f64> {
    site.pose.place(&site.context.environment.convention.pivot)
}

/// Positions are read with a factor of their own along each axis: `δt = diag(k) t`, `t` the point that is read.
#[derive(Clone, Copy, Debug)]
pub struct InstrumentScale;

impl Effect for InstrumentScale {
    describe!(
        "instrument.scale",
        "the instrument reads positions with a wrong scale along one or more axes",
        "check the scale of the instrument against a known length, its correction for the air, and the units of the file; \
         do not correct commands for it"
    );

    fn acts_on(&self) -> ActsOn {
        ActsOn::Measurement
    }

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        needs_places(context, available)
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        parameters(&["x", "y", "z"], Dimension::None, SCALE)
    }

    fn often_alone(&self, _setting: &EffectContext<'_>) -> Vec<Vec<f64>> {
        let mut directions = each_alone(3);
        directions.push(vec![1.0; 3]);
        directions
    }

    fn twins(&self) -> &[&str] {
        &["scale.common"]
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        Vec::new()
    }

    fn perturb(&self, theta: &[f64], _at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let read = read_point(site);
        for k in 0..3 {
            out.pose[k] += theta[k] * read[k];
        }
    }
}

/// Angles about home are read with a factor of their own each: `δω = E(α) diag(k) (α - α₀)`, with `E` the axes of the
/// angles.
#[derive(Clone, Copy, Debug)]
pub struct InstrumentRotationGain;

impl Effect for InstrumentRotationGain {
    describe!(
        "instrument.rotation_gain",
        "the instrument reads one or more angles with a wrong factor",
        "check the scale of the angle reading against a known angle, and the units of the file; do not correct commands \
         for it"
    );

    fn acts_on(&self) -> ActsOn {
        ActsOn::Measurement
    }

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        let mut missing = needs_places(context, available);
        if !context.mechanism.controlled()[3..].contains(&true) {
            missing.push("a platform that turns".into());
        }
        missing
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        parameters(&["rx", "ry", "rz"], Dimension::None, SMALL)
    }

    fn often_alone(&self, _setting: &EffectContext<'_>) -> Vec<Vec<f64>> {
        let mut directions = each_alone(3);
        directions.push(vec![1.0; 3]);
        directions
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        Vec::new()
    }

    fn perturb(&self, theta: &[f64], _at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let environment = site.context.environment;
        let convention = &environment.convention;
        let home = environment.home.unwrap_or_else(|| site.context.mechanism.home());
        let home = convention.angles(&home.rotation);
        let angles = convention.angles(&site.pose.rotation);
        let read = Vector3::from_fn(|k, _| theta[k] * wrapped_angle(angles[k] - home[k]));
        let turn = convention.angle_axes(&angles) * read;
        // The point whose position is read stays.
        let shift = turn.cross(&(site.pose.position - read_point(site)));
        out.pose += Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z);
    }
}

/// The axes of the instrument are not square: `δx = s_xy y + s_xz z`, `δy = s_yz z`.
#[derive(Clone, Copy, Debug)]
pub struct InstrumentSkew;

impl Effect for InstrumentSkew {
    describe!(
        "instrument.skew",
        "the axes of the instrument are not at right angles",
        "square the axes of the instrument, or measure a known body in several attitudes; do not correct commands for it"
    );

    fn acts_on(&self) -> ActsOn {
        ActsOn::Measurement
    }

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        needs_places(context, available)
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        parameters(&["xy", "xz", "yz"], Dimension::Angle, SMALL)
    }

    fn often_alone(&self, _setting: &EffectContext<'_>) -> Vec<Vec<f64>> {
        each_alone(3)
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        Vec::new()
    }

    fn perturb(&self, theta: &[f64], _at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let t = read_point(site);
        out.pose[0] += theta[0] * t.y + theta[1] * t.z;
        out.pose[1] += theta[2] * t.z;
    }
}
