//! Six cranks and rods.

use std::f64::consts::FRAC_PI_3;

use nalgebra::{Matrix6, Vector3};
use paracal::mechanism::kinds::{CrankLeg, RotaryStewart, Tolerances};
use paracal::mechanism::{GeometryError, Mechanism};

use super::{Design, Kind, Part, Spread, on_circle, point};
use crate::dice::Dice;
use crate::rigid::Rigid;

/// Per leg: platform point, base point, rod, crank, zero of the crank.
const PER_LEG: usize = 9;
const LEAST_HELD: f64 = 0.05;

/// The axis of each crank and where it points at zero.
struct Rotary {
    axes: Vec<[Vector3<f64>; 2]>,
    arm: f64,
}

impl Rotary {
    /// The crank angle nearer to zero, by the law of cosines in the plane of the crank.
    fn angle(&self, leg: usize, v: &[f64], pose: &Rigid) -> Option<f64> {
        let [axis, zero] = self.axes[leg];
        let across = axis.cross(&zero);
        let reach = pose.place(&point(v, 0)) - point(v, 3);
        let (x, y) = (reach.dot(&zero), reach.dot(&across));
        let (rod, crank) = (v[6], v[7]);
        let cosine = (reach.norm_squared() + crank * crank - rod * rod) / (2.0 * crank * (x * x + y * y).sqrt());
        if cosine.abs() > 0.98 {
            return None;
        }
        let (towards, open) = (y.atan2(x), cosine.acos());
        let wrap = |angle: f64| angle.sin().atan2(angle.cos());
        let [a, b] = [wrap(towards + open), wrap(towards - open)];
        let (near, far) = if a.abs() < b.abs() { (a, b) } else { (b, a) };
        (near.abs() < FRAC_PI_3 && far.abs() > near.abs() + 0.3).then_some(near)
    }
}

impl Kind for Rotary {
    fn name(&self) -> &'static str {
        "rotary-stewart"
    }

    fn parts(&self) -> Vec<Part> {
        let leg = (0..3).map(Part::Platform).chain((0..3).map(Part::Base));
        let leg: Vec<Part> = leg.chain([Part::Length, Part::Length, Part::ZeroAngle]).collect();
        leg.iter().copied().cycle().take(6 * PER_LEG).collect()
    }

    fn joints(&self, values: &[f64], pose: &Rigid) -> Option<Vec<f64>> {
        values.chunks(PER_LEG).enumerate().map(|(leg, v)| Some(self.angle(leg, v, pose)? - v[8])).collect()
    }

    /// As for a hexapod, with the rods for the legs.
    fn held(&self, values: &[f64], pose: &Rigid) -> f64 {
        let mut lines = Matrix6::zeros();
        for (leg, v) in values.chunks(PER_LEG).enumerate() {
            let Some(angle) = self.angle(leg, v, pose) else { return 0.0 };
            let [axis, zero] = self.axes[leg];
            let tip = point(v, 3) + (zero * angle.cos() + axis.cross(&zero) * angle.sin()) * v[7];
            let arm = pose.turn * point(v, 0);
            let along = (pose.at + arm - tip).normalize();
            let moment = arm.cross(&along) / self.arm;
            for k in 0..3 {
                lines[(leg, k)] = along[k];
                lines[(leg, 3 + k)] = moment[k];
            }
        }
        lines.determinant().signum() * lines.singular_values().min()
    }

    fn build(&self, values: &[f64], home: &Rigid, spread: &Spread) -> Result<Box<dyn Mechanism>, GeometryError> {
        let leg = |(v, [axis, zero]): (&[f64], &[Vector3<f64>; 2])| CrankLeg {
            platform: point(v, 0),
            base: point(v, 3),
            rod: v[6],
            crank: v[7],
            axis: *axis,
            zero: *zero,
            offset: v[8],
            stroke: None,
        };
        let legs: Vec<CrankLeg> = values.chunks(PER_LEG).zip(&self.axes).map(leg).collect();
        let tolerances = Tolerances { anchor: spread.anchor, length: spread.length, angle: spread.angle };
        Ok(Box::new(RotaryStewart::new("audited cranks", &legs, home.pose(), Some(tolerances))?))
    }
}

/// A machine whose cranks lie flat at home, in pairs that point away from each other.
pub(super) fn draw(dice: &mut Dice) -> Option<Design> {
    (0..100).find_map(|_| attempt(dice))
}

fn attempt(dice: &mut Dice) -> Option<Design> {
    let size = dice.log_uniform(0.1, 1.0);
    let arm = dice.uniform(0.6, 0.9) * size;
    let (crank, rise) = (dice.uniform(0.25, 0.4) * size, dice.uniform(0.9, 1.2) * size);
    let (base_half, platform_half) = (dice.uniform(15.0, 25.0), dice.uniform(42.0, 52.0));
    let home = Rigid::shifted(Vector3::new(0.0, 0.0, rise));
    let (mut values, mut axes) = (Vec::new(), Vec::new());
    for k in 0..6 {
        let pair = 120.0 * (k / 2) as f64;
        let side = if k % 2 == 0 { -1.0 } else { 1.0 };
        let radial = on_circle(1.0, pair, 0.0);
        let zero = on_circle(1.0, pair + 90.0, 0.0) * side;
        let (a, b) = (on_circle(arm, pair + side * platform_half, 0.0), on_circle(size, pair + side * base_half, 0.0));
        let rod = (home.place(&a) - b - zero * crank).norm();
        axes.push([radial * -side, zero]);
        values.extend(a.iter().chain(b.iter()).chain(&[rod, crank, 0.0]));
    }
    let kind = Rotary { axes, arm };
    let (shift, turn) = (dice.log_uniform(0.02, 0.1) * size, dice.log_uniform(1.0, 8.0).to_radians());
    let half: [f64; 6] = std::array::from_fn(|k| if k < 3 { shift } else { turn });
    let side = kind.held(&values, &home).signum();
    let corner = |bits: usize| {
        let u: [f64; 6] = std::array::from_fn(|k| if bits >> k & 1 == 1 { half[k] } else { -half[k] });
        side * kind.held(&values, &home.moved(&Vector3::new(u[0], u[1], u[2]), &Vector3::new(u[3], u[4], u[5])))
    };
    (0..64).all(|bits| corner(bits) > LEAST_HELD).then(|| Design::new(kind, values, home, half, size, arm))
}
