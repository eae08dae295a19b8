//! Three legs on hinges.

use nalgebra::Vector3;
use paracal::mechanism::kinds::{HingedLeg, Tolerances, Tripod};
use paracal::mechanism::{GeometryError, Mechanism};

use super::{Design, Kind, Part, Spread, on_circle, point};
use crate::dice::Dice;
use crate::rigid::{Rigid, turn_by};

/// Per leg: platform point, base point, zero of the length, two tilts of the hinge.
const PER_LEG: usize = 9;

/// The axes of the hinges by the design.
struct Hinged {
    axes: Vec<Vector3<f64>>,
}

impl Hinged {
    /// The axis of a leg, tilted upwards and sideways.
    fn axis(&self, leg: usize, v: &[f64]) -> Vector3<f64> {
        let axis = self.axes[leg];
        let sideways = axis.cross(&Vector3::z());
        turn_by(&(sideways * v[7] + Vector3::z() * v[8])) * axis
    }
}

impl Kind for Hinged {
    fn name(&self) -> &'static str {
        "tripod-3rps"
    }

    fn parts(&self) -> Vec<Part> {
        let leg = (0..3).map(Part::Platform).chain((0..3).map(Part::Base));
        let leg: Vec<Part> = leg.chain([Part::ZeroLength, Part::Angle, Part::Angle]).collect();
        leg.iter().copied().cycle().take(3 * PER_LEG).collect()
    }

    fn joints(&self, values: &[f64], pose: &Rigid) -> Option<Vec<f64>> {
        Some(values.chunks(PER_LEG).map(|v| (pose.place(&point(v, 0)) - point(v, 3)).norm() - v[6]).collect())
    }

    fn follows(&self) -> &[usize] {
        &[0, 1, 5]
    }

    /// How far each leg is out of the plane of its hinge.
    fn misses(&self, values: &[f64], pose: &Rigid) -> Vec<f64> {
        let miss = |(leg, v): (usize, &[f64])| (pose.place(&point(v, 0)) - point(v, 3)).dot(&self.axis(leg, v));
        values.chunks(PER_LEG).enumerate().map(miss).collect()
    }

    /// Tilts of the hinge are written as another axis: which way the library counts them is its own affair.
    fn build(&self, values: &[f64], home: &Rigid, spread: &Spread) -> Result<Box<dyn Mechanism>, GeometryError> {
        let leg = |(leg, v): (usize, &[f64])| HingedLeg {
            platform: point(v, 0),
            base: point(v, 3),
            axis: self.axis(leg, v),
            tilt: [0.0; 2],
            offset: v[6],
            stroke: None,
        };
        let legs: Vec<HingedLeg> = values.chunks(PER_LEG).enumerate().map(leg).collect();
        let tolerances = Tolerances { anchor: spread.anchor, length: spread.length, angle: spread.angle };
        Ok(Box::new(Tripod::new("audited tripod", &legs, home.pose(), Some(tolerances))?))
    }
}

/// A tip-tilt-piston stage.
pub(super) fn draw(dice: &mut Dice) -> Option<Design> {
    let size = dice.log_uniform(0.1, 1.5);
    let arm = dice.uniform(0.5, 0.9) * size;
    let home = Rigid::shifted(Vector3::new(0.0, 0.0, dice.uniform(0.9, 1.6) * size));
    let first = dice.uniform(0.0, 120.0);
    let (mut values, mut axes) = (Vec::new(), Vec::new());
    for k in 0..3 {
        let degrees = first + 120.0 * k as f64;
        axes.push(on_circle(1.0, degrees + 90.0, 0.0));
        let (a, b) = (on_circle(arm, degrees, 0.0), on_circle(size, degrees, 0.0));
        values.extend(a.iter().chain(b.iter()).chain(&[0.0; 3]));
    }
    let (piston, tilt) = (dice.log_uniform(0.02, 0.2) * size, dice.log_uniform(2.0, 12.0).to_radians());
    Some(Design::new(Hinged { axes }, values, home, [0.0, 0.0, piston, tilt, tilt, 0.0], size, arm))
}
