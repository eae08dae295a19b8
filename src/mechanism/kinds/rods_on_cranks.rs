//! Six rods on cranks: one crank to each (6-RSS, the rotary Stewart platform), or one to two (the rotary delta, with its
//! parallelograms as they are).

use nalgebra::Vector3;

use super::{Tolerances, count, positive, rods_in_words, unit};
use crate::mechanism::closure::{Closure, ClosureMechanism, Column, Outline, Real, State, length};
use crate::mechanism::{GeometryError, ParameterRole};
use crate::pose::Pose;
use crate::units::Dimension;

/// One leg: a crank about a fixed axis, and a rod from its tip to the platform. SI.
#[derive(Clone, Debug, PartialEq)]
pub struct CrankLeg {
    /// Where the rod meets the platform, platform frame.
    pub platform: Vector3<f64>,
    /// Centre of the circle on which the rod's other end moves, base frame.
    pub base: Vector3<f64>,
    /// Length of the rod.
    pub rod: f64,
    /// Radius of the crank.
    pub crank: f64,
    /// Axis about which the crank turns by the right hand, base frame; any length.
    pub axis: Vector3<f64>,
    /// Where the crank points at angle zero, base frame; made perpendicular to the axis.
    pub zero: Vector3<f64>,
    /// True crank angle less the commanded one, rad.
    pub offset: f64,
    /// Smallest and largest commanded angle, rad.
    pub stroke: Option<[f64; 2]>,
}

/// Closure of six rods on cranks.
#[derive(Clone, Debug, PartialEq)]
pub struct RodsOnCranks {
    /// `u` and `v` of each crank: where it points at 0 and at 90°.
    directions: Vec<[Vector3<f64>; 2]>,
    rods: Vec<RodPlaces>,
}

/// Where the parameters of a rod are.
#[derive(Clone, Debug, PartialEq)]
struct RodPlaces {
    /// First of `a b s`.
    first: usize,
    motor: usize,
    /// First of `r o` of the crank.
    crank: usize,
}

/// Six cranks with one rod each.
#[derive(Clone, Copy, Debug)]
pub struct RotaryStewart;

/// Three cranks with two rods each.
#[derive(Clone, Copy, Debug)]
pub struct RotaryDelta;

const RODS: usize = 6;
const PER_ROD: usize = 7;
const PER_CRANK: usize = 2;

impl RotaryStewart {
    /// A rotary Stewart platform. Of the two crank angles that reach home the one nearer to zero is taken.
    ///
    /// # Errors
    /// [`GeometryError`] for anything but six legs that reach home and hold the platform there.
    #[allow(clippy::new_ret_no_self)]
    pub fn new(
        name: &str,
        legs: &[CrankLeg],
        home: Pose,
        tolerances: Option<Tolerances>,
    ) -> Result<ClosureMechanism<RodsOnCranks>, GeometryError> {
        count("rotary Stewart platform", "legs", RODS, legs.len())?;
        let mut outline = Outline::new(name, RODS, home);
        let mut closure = RodsOnCranks { directions: Vec::new(), rods: Vec::new() };
        for (leg, l) in legs.iter().enumerate() {
            outline = closure.rod(outline, leg, l, leg, tolerances.as_ref())?;
            outline = closure.crank(outline, leg, l, tolerances.as_ref())?;
        }
        ClosureMechanism::new(closure, outline)
    }
}

impl RotaryDelta {
    /// A rotary delta: six rods, each with the number of its crank from 0, and the crank as every rod on it states it. Its joints
    /// control x, y and z. Of the two crank angles that reach home the one nearer to zero is taken.
    ///
    /// # Errors
    /// [`GeometryError`] for anything but two rods on each of three cranks, of which both say the same, that reach home and
    /// hold the platform there.
    #[allow(clippy::new_ret_no_self)]
    pub fn new(
        name: &str,
        rods: &[(usize, CrankLeg)],
        home: Pose,
        tolerances: Option<Tolerances>,
    ) -> Result<ClosureMechanism<RodsOnCranks>, GeometryError> {
        count("rotary delta", "rods", RODS, rods.len())?;
        let mut outline = Outline::new(name, RODS, home).controls([true, true, true, false, false, false]);
        let mut closure = RodsOnCranks { directions: Vec::new(), rods: Vec::new() };
        for (leg, (motor, l)) in rods.iter().enumerate() {
            outline = closure.rod(outline, leg, l, *motor, tolerances.as_ref())?;
        }
        for motor in 0..3 {
            let mine: Vec<usize> = (0..RODS).filter(|k| rods[*k].0 == motor).collect();
            let [first, other] = mine[..] else {
                return Err(GeometryError::Outline(format!(
                    "motor {} has {}; a rotary delta has two on each of three motors",
                    motor + 1,
                    rods_in_words(mine.len())
                )));
            };
            let (a, b) = (&rods[first].1, &rods[other].1);
            let same = a.axis == b.axis && a.zero == b.zero && a.stroke == b.stroke;
            if !same || a.crank != b.crank || a.offset != b.offset {
                return Err(GeometryError::Outline(format!(
                    "legs {} and {} are on the same motor but state different cranks, axes, zeros, offsets or strokes",
                    first + 1,
                    other + 1
                )));
            }
            outline = closure.crank(outline, first, a, tolerances.as_ref())?;
        }
        for rod in &mut closure.rods {
            rod.crank = PER_ROD * RODS + PER_CRANK * rod.motor;
        }
        ClosureMechanism::new(closure, outline)
    }
}

impl RodsOnCranks {
    /// Adds `a b s` of a rod, whose crank follows at once unless that is said otherwise.
    fn rod(
        &mut self,
        outline: Outline,
        leg: usize,
        l: &CrankLeg,
        motor: usize,
        tolerances: Option<&Tolerances>,
    ) -> Result<Outline, GeometryError> {
        positive(leg, "length", l.rod)?;
        positive(leg, "crank", l.crank)?;
        let first = outline.parameters.len();
        self.rods.push(RodPlaces { first, motor, crank: first + PER_ROD });
        let sigma = |f: fn(&Tolerances) -> f64| tolerances.map(f);
        let role = ParameterRole::LegDimension { leg };
        Ok(outline
            .platform_point(leg, l.platform.into(), sigma(|t| t.anchor))
            .base_point(leg, l.base.into(), sigma(|t| t.anchor))
            .parameter(format!("s{}", leg + 1), Dimension::Length, l.rod, sigma(|t| t.length), role))
    }

    /// Adds `r o` of the next crank, and its joint, as rod `leg` states them.
    fn crank(
        &mut self,
        outline: Outline,
        leg: usize,
        l: &CrankLeg,
        tolerances: Option<&Tolerances>,
    ) -> Result<Outline, GeometryError> {
        let axis = unit(leg, "axis", &l.axis)?;
        let u = unit(leg, "zero", &(l.zero - axis * axis.dot(&l.zero)))?;
        let v = axis.cross(&u);
        let angle = crank_angle(l, &outline.home, &u, &v).ok_or_else(|| {
            GeometryError::Outline(format!("leg {}: its rod does not reach the platform at home", leg + 1))
        })?;
        self.directions.push([u, v]);
        let n = self.directions.len();
        let motor = n - 1;
        let sigma = |f: fn(&Tolerances) -> f64| tolerances.map(f);
        let (radius, offset) = (ParameterRole::LegDimension { leg: motor }, ParameterRole::JointOffset { leg: motor });
        Ok(outline
            .parameter(format!("r{n}"), Dimension::Length, l.crank, sigma(|t| t.length), radius)
            .parameter(format!("o{n}"), Dimension::Angle, l.offset, sigma(|t| t.angle), offset)
            .joint(format!("leg{n}"), Dimension::Angle, angle - l.offset, l.stroke))
    }
}

/// The crank angle nearer to zero at which the rod reaches the platform.
fn crank_angle(l: &CrankLeg, home: &Pose, u: &Vector3<f64>, v: &Vector3<f64>) -> Option<f64> {
    // |d - r (cos φ u + sin φ v)| = s, so (d·u) cos φ + (d·v) sin φ = (d² + r² - s²)/2r.
    let d = home.place(&l.platform) - l.base;
    let (x, y) = (d.dot(u), d.dot(v));
    let cos = (d.norm_squared() + l.crank.powi(2) - l.rod.powi(2)) / (2.0 * l.crank * x.hypot(y));
    let (middle, half) = (y.atan2(x), cos.acos());
    let turned = |angle: f64| angle.sin().atan2(angle.cos());
    let (a, b) = (turned(middle + half), turned(middle - half));
    let nearer = if a.abs() <= b.abs() { a } else { b };
    nearer.is_finite().then_some(nearer)
}

impl Closure for RodsOnCranks {
    fn residual<T: Real>(&self, s: &State<'_, T>, out: &mut [T]) {
        for (row, rod) in self.rods.iter().enumerate() {
            let (crank, offset) = (s.parameters[rod.crank], s.parameters[rod.crank + 1]);
            let (sin, cos) = (s.joints[rod.motor] + offset).sin_cos();
            let (x, y) = (crank * cos, crank * sin);
            let [u, v] = &self.directions[rod.motor];
            let tip = s.place(&s.point(rod.first)) - s.point(rod.first + 3);
            let along_rod = Vector3::from_fn(|k, _| tip[k] - x * u[k] - y * v[k]);
            out[row] = length(&along_rod) - s.parameters[rod.first + 6];
        }
    }

    fn depends(&self, row: usize, on: Column) -> bool {
        let rod = &self.rods[row];
        match on {
            Column::Parameter(k) => {
                (rod.first..rod.first + PER_ROD).contains(&k) || (rod.crank..rod.crank + PER_CRANK).contains(&k)
            }
            Column::Joint(k) => k == rod.motor,
        }
    }
}
