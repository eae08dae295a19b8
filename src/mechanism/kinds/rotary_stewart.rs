//! Six rods, each moved by a crank on the base: 6-RSS, the rotary Stewart platform.

use nalgebra::Vector3;

use super::{Tolerances, count, positive, unit};
use crate::mechanism::closure::{Closure, ClosureMechanism, Column, Outline, Real, State, length};
use crate::mechanism::{GeometryError, ParameterRole};
use crate::pose::Pose;
use crate::units::Dimension;

/// One leg: a crank about a fixed axis, and a rod from its tip to the platform. SI.
#[derive(Clone, Debug, PartialEq)]
pub struct CrankLeg {
    /// Where the rod meets the platform, platform frame.
    pub platform: Vector3<f64>,
    /// Centre of the crank's circle, base frame.
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

/// Closure of six cranked legs.
#[derive(Clone, Debug, PartialEq)]
pub struct RotaryStewart {
    /// `u` and `v`: where each crank points at 0 and at 90°.
    directions: Vec<[Vector3<f64>; 2]>,
}

const LEGS: usize = 6;
const PER_LEG: usize = 9;

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
    ) -> Result<ClosureMechanism<Self>, GeometryError> {
        count("rotary Stewart platform", "legs", LEGS, legs.len())?;
        let mut outline = Outline::new(name, LEGS, home);
        let mut directions = Vec::with_capacity(LEGS);
        for (leg, l) in legs.iter().enumerate() {
            positive(leg, "length", l.rod)?;
            positive(leg, "crank", l.crank)?;
            let axis = unit(leg, "axis", &l.axis)?;
            let u = unit(leg, "zero", &(l.zero - axis * axis.dot(&l.zero)))?;
            let v = axis.cross(&u);
            let angle = crank_angle(l, &home, &u, &v).ok_or_else(|| {
                GeometryError::Outline(format!("leg {}: its rod does not reach the platform at home", leg + 1))
            })?;
            let sigma = |f: fn(&Tolerances) -> f64| tolerances.as_ref().map(f);
            let (dimension, role) = (Dimension::Length, ParameterRole::LegDimension { leg });
            let n = leg + 1;
            outline = outline
                .platform_point(leg, l.platform.into(), sigma(|t| t.anchor))
                .base_point(leg, l.base.into(), sigma(|t| t.anchor))
                .parameter(format!("s{n}"), dimension, l.rod, sigma(|t| t.length), role)
                .parameter(format!("r{n}"), dimension, l.crank, sigma(|t| t.length), role)
                .parameter(
                    format!("o{n}"),
                    Dimension::Angle,
                    l.offset,
                    sigma(|t| t.angle),
                    ParameterRole::JointOffset { leg },
                )
                .joint(format!("leg{n}"), Dimension::Angle, angle - l.offset, l.stroke);
            directions.push([u, v]);
        }
        ClosureMechanism::new(Self { directions }, outline)
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

impl Closure for RotaryStewart {
    fn residual<T: Real>(&self, s: &State<'_, T>, out: &mut [T]) {
        for (leg, [u, v]) in self.directions.iter().enumerate() {
            let first = PER_LEG * leg;
            let (rod, crank, offset) = (s.parameters[first + 6], s.parameters[first + 7], s.parameters[first + 8]);
            let (sin, cos) = (s.joints[leg] + offset).sin_cos();
            let (x, y) = (crank * cos, crank * sin);
            let tip = s.place(&s.point(first)) - s.point(first + 3);
            let along_rod = Vector3::from_fn(|k, _| tip[k] - x * u[k] - y * v[k]);
            out[leg] = length(&along_rod) - rod;
        }
    }

    fn depends(&self, row: usize, on: Column) -> bool {
        match on {
            Column::Parameter(k) => k / PER_LEG == row,
            Column::Joint(k) => k == row,
        }
    }
}
