//! Three legs of variable length on hinges: the 3-RPS tripod.

use nalgebra::Vector3;

use super::{Tolerances, count, direction, positive};
use crate::mechanism::closure::{Closure, ClosureMechanism, Column, Direction, Outline, Real, State, length};
use crate::mechanism::{GeometryError, ParameterRole};
use crate::pose::Pose;
use crate::units::Dimension;

/// One leg of variable length, on a hinge at the base and a ball joint at the platform. SI.
#[derive(Clone, Debug, PartialEq)]
pub struct HingedLeg {
    /// Where it meets the platform, platform frame.
    pub platform: Vector3<f64>,
    /// A point of the hinge's axis in the plane of the leg, base frame.
    pub base: Vector3<f64>,
    /// Axis of the hinge, base frame; any length. The leg moves in the plane through `base` perpendicular to it.
    pub axis: Vector3<f64>,
    /// Two small tilts of the axis in directions across it, rad.
    pub tilt: [f64; 2],
    /// True length less the commanded one.
    pub offset: f64,
    /// Shortest and longest commanded length.
    pub stroke: Option<[f64; 2]>,
}

/// Closure of three hinged legs.
#[derive(Clone, Debug, PartialEq)]
pub struct Tripod {
    /// Nominal axis of each hinge.
    hinges: Vec<Direction>,
}

const LEGS: usize = 3;
const PER_LEG: usize = 9;

impl Tripod {
    /// A tripod. Its joints control z, α and β; x, y and γ follow.
    ///
    /// # Errors
    /// [`GeometryError`] for anything but three legs that close at home and hold the platform there.
    #[allow(clippy::new_ret_no_self)]
    pub fn new(
        name: &str,
        legs: &[HingedLeg],
        home: Pose,
        tolerances: Option<Tolerances>,
    ) -> Result<ClosureMechanism<Self>, GeometryError> {
        count("3-RPS tripod", "legs", LEGS, legs.len())?;
        let mut outline = Outline::new(name, 2 * LEGS, home).controls([false, false, true, true, true, false]);
        let mut hinges = Vec::with_capacity(LEGS);
        for (leg, l) in legs.iter().enumerate() {
            hinges.push(direction(leg, "axis", &l.axis)?);
            let at_home = (home.place(&l.platform) - l.base).norm();
            positive(leg, "length at home", at_home)?;
            let sigma = |f: fn(&Tolerances) -> f64| tolerances.as_ref().map(f);
            let role = ParameterRole::Direction { leg };
            let n = leg + 1;
            outline = outline
                .platform_point(leg, l.platform.into(), sigma(|t| t.anchor))
                .base_point(leg, l.base.into(), sigma(|t| t.anchor))
                .parameter(
                    format!("o{n}"),
                    Dimension::Length,
                    l.offset,
                    sigma(|t| t.length),
                    ParameterRole::JointOffset { leg },
                )
                .parameter(format!("m{n}"), Dimension::Angle, l.tilt[0], sigma(|t| t.angle), role)
                .parameter(format!("n{n}"), Dimension::Angle, l.tilt[1], sigma(|t| t.angle), role)
                .joint(format!("leg{n}"), Dimension::Length, at_home - l.offset, l.stroke);
        }
        ClosureMechanism::new(Self { hinges }, outline)
    }
}

impl Closure for Tripod {
    fn residual<T: Real>(&self, s: &State<'_, T>, out: &mut [T]) {
        for (leg, axis) in self.hinges.iter().enumerate() {
            let first = PER_LEG * leg;
            let l = s.place(&s.point(first)) - s.point(first + 3);
            out[2 * leg] = length(&l) - s.joints[leg] - s.parameters[first + 6];
            let normal = s.turned(axis, first + 7);
            out[2 * leg + 1] = l.dot(&normal) / length(&normal);
        }
    }

    fn depends(&self, row: usize, on: Column) -> bool {
        match on {
            Column::Parameter(k) => k / PER_LEG == row / 2,
            Column::Joint(k) => 2 * k == row,
        }
    }
}
