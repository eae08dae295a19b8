//! Growth with temperature.
//!
//! Steel grows by 11 to 12 ppm/K, so that a leg of 800 mm grows by 9 µm per kelvin and a base of 1.5 m radius by 18 µm.
//! A temperature acts by its difference from the reference temperature of the mechanism file, or from the mean of
//! its column. A part follows the sensor on it at once, or with a time constant of minutes to hours, which is scanned where
//! times are recorded ([`ScanPoint::lag`]). Confused with: each other and drifts, when all temperatures rise with time. More poses do not help then;
//! poses after cooling down do, or one part heated alone.

use nalgebra::{DMatrix, DVector, Vector3};

use super::{describe, of_legs, unrecorded};
use crate::conditions::{TEMP_BASE, TEMP_LEG, TEMP_LEGS, TEMP_PLATFORM, of_leg};
use crate::effect::{AvailableData, Effect, EffectContext, EffectParameter, Perturbation, Scan, ScanPoint, Site};
use crate::mechanism::Body;
use crate::solve::svd;
use crate::units::Dimension;

/// Prior scale of a coefficient of expansion, 1/K.
const EXPANSION: f64 = 1e-5;

fn expansion() -> Vec<EffectParameter> {
    vec![EffectParameter::new("expansion", Dimension::PerKelvin, EXPANSION).never_negative()]
}

/// Legs that are lengths; an angle does not grow.
fn needs_lengths(context: &EffectContext<'_>) -> Vec<String> {
    let ok = context.joints_are_lengths() && !context.is_pose_space();
    if ok { Vec::new() } else { vec!["legs of variable length".into()] }
}

/// All legs grow with their mean temperature.
#[derive(Clone, Copy, Debug)]
pub struct ThermalLegsUniform;

impl Effect for ThermalLegsUniform {
    describe!(
        "thermal.legs.uniform",
        "all legs expand with their mean temperature",
        "measure the temperature of the legs and correct the commanded lengths for it, or use legs that expand less"
    );

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        let mut missing = needs_lengths(context);
        let own = (0..context.joints()).all(|leg| available.has(&of_leg(TEMP_LEG, leg)));
        if !available.has(TEMP_LEGS) && !own {
            missing.push(TEMP_LEGS.into());
        }
        missing
    }

    fn may_lag(&self) -> bool {
        true
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        expansion()
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        vec![TEMP_LEGS.into()]
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let Some(t) = site.temperature_at(TEMP_LEGS, at) else { return };
        for (delta, length) in out.joints.iter_mut().zip(site.joints) {
            *delta += theta[0] * length * t;
        }
    }
}

/// Each leg grows with its own temperature.
#[derive(Clone, Copy, Debug)]
pub struct ThermalLegsIndividual;

impl Effect for ThermalLegsIndividual {
    describe!(
        "thermal.legs.individual",
        "each leg expands with its own temperature",
        "correct each commanded length for the temperature of its leg; find what heats the legs differently"
    );

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        let names: Vec<String> = (0..context.joints()).map(|leg| of_leg(TEMP_LEG, leg)).collect();
        let mut missing = needs_lengths(context);
        missing.extend(names.into_iter().filter(|n| !available.has(n)));
        missing
    }

    fn may_lag(&self) -> bool {
        true
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        expansion()
    }

    fn covariates(&self, at: &ScanPoint) -> Vec<String> {
        of_legs(TEMP_LEG, at)
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        for (leg, (delta, length)) in out.joints.iter_mut().zip(site.joints).enumerate() {
            if let Some(t) = site.temperature_at(&of_leg(TEMP_LEG, leg), at) {
                *delta += theta[0] * length * t;
            }
        }
    }
}

/// One leg grows differently from the others.
#[derive(Clone, Copy, Debug)]
pub struct ThermalLegSingle;

impl Effect for ThermalLegSingle {
    describe!(
        "thermal.leg.single",
        "one leg expands with its temperature unlike the others: a different material, a bad sensor, or the heat of \
         its motor",
        "check the material and the temperature sensor of that leg, and what warms it"
    );

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        ThermalLegsIndividual.missing(context, available)
    }

    fn may_lag(&self) -> bool {
        true
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        // Beside growth of all legs it is a difference.
        vec![EffectParameter::new("expansion", Dimension::PerKelvin, EXPANSION)]
    }

    fn scan(&self, _setting: &EffectContext<'_>, _recorded: &AvailableData) -> Scan {
        Scan::Legs
    }

    fn covariates(&self, at: &ScanPoint) -> Vec<String> {
        at.leg.map(|leg| of_leg(TEMP_LEG, leg)).into_iter().collect()
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let Some(leg) = at.leg else { return };
        if let Some(t) = site.temperature_at(&of_leg(TEMP_LEG, leg), at) {
            out.joints[leg] += theta[0] * site.joints[leg] * t;
        }
    }
}

/// Adds `factor(place) · place` to every point of a body.
fn grow(body: Body, site: &Site<'_>, out: &mut Perturbation, factor: impl Fn(&Vector3<f64>) -> f64) {
    let points = body.points(site.context.mechanism, site.values);
    for (k, spec) in site.context.mechanism.parameters().iter().enumerate() {
        let Some((leg, axis)) = body.coordinate(spec.role) else { continue };
        if let Some((_, place)) = points.iter().find(|(l, _)| *l == leg) {
            out.parameters[k] += factor(place) * place[axis];
        }
    }
}

fn body_missing(context: &EffectContext<'_>, available: &AvailableData, body: Body, column: &str) -> Vec<String> {
    let mut missing = unrecorded(available, &[column]);
    if !context.has_points(body) {
        let name = if body == Body::Platform { "platform" } else { "base" };
        missing.push(format!("{name} points among the parameters"));
    }
    missing
}

/// The platform grows.
#[derive(Clone, Copy, Debug)]
pub struct ThermalPlatform;

impl Effect for ThermalPlatform {
    describe!(
        "thermal.platform",
        "the platform expands with its temperature, and the joints on it move outwards",
        "correct for the temperature of the platform, or choose a material for it that expands less"
    );

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        body_missing(context, available, Body::Platform, TEMP_PLATFORM)
    }

    fn may_lag(&self) -> bool {
        true
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        expansion()
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        vec![TEMP_PLATFORM.into()]
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        if let Some(t) = site.temperature_at(TEMP_PLATFORM, at) {
            grow(Body::Platform, site, out, |_| theta[0] * t);
        }
    }
}

/// The base grows.
#[derive(Clone, Copy, Debug)]
pub struct ThermalBase;

impl Effect for ThermalBase {
    describe!(
        "thermal.base",
        "the base expands with its temperature, and the joints on it move outwards",
        "correct for the temperature of the base, or let it reach a steady temperature before use"
    );

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        body_missing(context, available, Body::Base, TEMP_BASE)
    }

    fn may_lag(&self) -> bool {
        true
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        expansion()
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        vec![TEMP_BASE.into()]
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        if let Some(t) = site.temperature_at(TEMP_BASE, at) {
            grow(Body::Base, site, out, |_| theta[0] * t);
        }
    }
}

/// The base grows unevenly: a temperature that changes linearly through it, from three or more sensors. A point moves by
/// the integral of the strain along the way from the origin, `α (T₀' + ½ G·b) b`. Typical: 10 to 20 µm for 1 K across 3 m.
#[derive(Clone, Copy, Debug)]
pub struct ThermalGradient;

impl ThermalGradient {
    /// Temperature at the origin and its gradient, as least squares through the sensors of the base.
    fn field(site: &Site<'_>, at: &ScanPoint) -> Option<(f64, Vector3<f64>)> {
        let sensors = site.context.environment.sensors.iter().filter(|s| s.body == Body::Base);
        let known: Vec<_> = sensors.filter_map(|s| Some((s.place, site.temperature_at(&s.covariate, at)?))).collect();
        if known.len() < 3 {
            return None;
        }
        let n = known.len() as f64;
        let centre = known.iter().map(|(p, _)| p).sum::<Vector3<f64>>() / n;
        let mean = known.iter().map(|(_, t)| t).sum::<f64>() / n;
        let rows = DMatrix::from_fn(known.len(), 3, |i, k| known[i].0[k] - centre[k]);
        let values = DVector::from_iterator(known.len(), known.iter().map(|(_, t)| t - mean));
        // Sensors in one plane leave the gradient across it at zero.
        let found = svd(rows, true, true).solve(&values, 1e-9).ok()?;
        let gradient = Vector3::new(found[0], found[1], found[2]);
        Some((mean - gradient.dot(&centre), gradient))
    }
}

impl Effect for ThermalGradient {
    describe!(
        "thermal.gradient",
        "the base expands unevenly, because one side of it is warmer than the other",
        "shield the base from the heat source, or correct for the temperatures of its sensors"
    );

    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        let mut missing = Vec::new();
        let on_base: Vec<_> = context.environment.sensors.iter().filter(|s| s.body == Body::Base).collect();
        if on_base.len() < 3 {
            missing.push("three [[sensor]] entries on the base".into());
        }
        missing.extend(on_base.iter().filter(|s| !available.has(&s.covariate)).map(|s| s.covariate.clone()));
        if !context.has_points(Body::Base) {
            missing.push("base points among the parameters".into());
        }
        missing
    }

    fn may_lag(&self) -> bool {
        true
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        expansion()
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        Vec::new()
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        if let Some((mean, gradient)) = Self::field(site, at) {
            grow(Body::Base, site, out, |place| theta[0] * (mean + 0.5 * gradient.dot(place)));
        }
    }
}
