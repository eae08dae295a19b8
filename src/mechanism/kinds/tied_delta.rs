//! The linear delta by the numbers of its firmware: for each tower the endstop, the radius, the angle and the arm.
//!
//! The parallelograms are taken as perfect, so that the effector does not turn, and the carriages as moving along z. What that
//! leaves out is what a tilted effector or a bent bed does; what it gains is that its directions are those that owners know.

use nalgebra::Vector3;

use super::{Tolerances, positive};
use crate::mechanism::closure::{Closure, ClosureMechanism, Column, Outline, Real, State, length};
use crate::mechanism::{GeometryError, ParameterRole};
use crate::pose::Pose;
use crate::units::Dimension;

/// A number of each tower, or one for all three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PerTower {
    /// One parameter that all towers share.
    Shared(f64),
    /// Three parameters.
    Each([f64; 3]),
}

impl PerTower {
    /// The number of a tower.
    pub fn of(&self, tower: usize) -> f64 {
        match self {
            Self::Shared(value) => *value,
            Self::Each(values) => values[tower],
        }
    }
}

/// The towers of a linear delta, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Towers {
    /// Height of each carriage at coordinate zero.
    pub endstop: PerTower,
    /// Horizontal distance of the arm's joint on the carriage from that on the effector when the effector is on the axis: the
    /// radius of the tower less that of the effector.
    pub radius: PerTower,
    /// Direction of each tower, counted from x to y.
    pub angle: [f64; 3],
    /// Length of the arm.
    pub arm: PerTower,
    /// Smallest and largest coordinate of the carriages.
    pub stroke: Option<[f64; 2]>,
}

/// Closure of three tied pairs of rods.
#[derive(Clone, Debug, PartialEq)]
pub struct TiedDelta {
    /// Places of endstop, radius, angle and arm of each tower among the parameters.
    places: [[usize; 4]; 3],
    /// By which a tilt becomes a length, m.
    size: f64,
}

const TOWERS: usize = 3;

impl TiedDelta {
    /// A linear delta. Its joints control x, y and z; of the two carriage positions that reach home the upper one is taken.
    ///
    /// # Errors
    /// [`GeometryError`] if arms do not reach home, or carriages do not hold the effector there.
    #[allow(clippy::new_ret_no_self)]
    pub fn new(
        name: &str,
        towers: &Towers,
        home: Pose,
        tolerances: Option<Tolerances>,
    ) -> Result<ClosureMechanism<Self>, GeometryError> {
        let q = home.coordinates();
        if q[3..].iter().any(|v| v.abs() > 1e-9) {
            return Err(GeometryError::Outline(
                "the effector of [delta] does not turn: write zero rotations for home".into(),
            ));
        }
        let mut outline = Outline::new(name, 2 * TOWERS, home).controls([true, true, true, false, false, false]);
        let mut places = [[0; 4]; 3];
        let angle = PerTower::Each(towers.angle);
        let groups = [
            ("endstop", &towers.endstop, Dimension::Length),
            ("tower_radius", &towers.radius, Dimension::Length),
            ("tower_angle", &angle, Dimension::Angle),
            ("arm", &towers.arm, Dimension::Length),
        ];
        for (group, (stem, values, dimension)) in groups.into_iter().enumerate() {
            let sigma = tolerances.as_ref().map(|t| if dimension == Dimension::Angle { t.angle } else { t.length });
            for (leg, place) in places.iter_mut().enumerate() {
                let value = values.of(leg);
                if matches!(stem, "tower_radius" | "arm") {
                    positive(leg, stem, value)?;
                }
                let (name, role) = match (values, stem) {
                    (PerTower::Shared(_), _) => (stem.to_owned(), ParameterRole::Other),
                    (_, "endstop") => (format!("{stem}{}", leg + 1), ParameterRole::JointOffset { leg }),
                    _ => (format!("{stem}{}", leg + 1), ParameterRole::LegDimension { leg }),
                };
                if leg == 0 || matches!(values, PerTower::Each(_)) {
                    outline = outline.parameter(name, dimension, value, sigma, role);
                }
                place[group] = outline.parameters.len() - 1;
            }
        }
        for leg in 0..TOWERS {
            let (sin, cos) = towers.angle[leg].sin_cos();
            let radius = towers.radius.of(leg);
            let across = (home.position.x - radius * cos).hypot(home.position.y - radius * sin);
            let rise = (towers.arm.of(leg).powi(2) - across.powi(2)).sqrt();
            if !rise.is_finite() {
                let problem = format!("tower {}: its arm does not reach the effector at home", leg + 1);
                return Err(GeometryError::Outline(problem));
            }
            let near = home.position.z + rise - towers.endstop.of(leg);
            outline = outline.joint(format!("leg{}", leg + 1), Dimension::Length, near, towers.stroke);
        }
        ClosureMechanism::new(Self { places, size: towers.radius.of(0) }, outline)
    }
}

impl Closure for TiedDelta {
    fn residual<T: Real>(&self, s: &State<'_, T>, out: &mut [T]) {
        for (tower, places) in self.places.iter().enumerate() {
            let [endstop, radius, angle, arm] = places.map(|k| s.parameters[k]);
            let (sin, cos) = angle.sin_cos();
            let carriage = Vector3::new(radius * cos, radius * sin, s.joints[tower] + endstop);
            out[tower] = length(&(s.position - carriage)) - arm;
        }
        // The effector stays level.
        for (row, (i, k)) in out[TOWERS..].iter_mut().zip([(2, 1), (0, 2), (1, 0)]) {
            *row = s.rotation[(i, k)] * self.size;
        }
    }

    fn depends(&self, row: usize, on: Column) -> bool {
        let Some(places) = self.places.get(row) else { return false };
        match on {
            Column::Parameter(k) => places.contains(&k),
            Column::Joint(k) => k == row,
        }
    }
}
