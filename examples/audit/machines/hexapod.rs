//! Six legs of variable length.

use nalgebra::{Matrix6, Vector3};
use paracal::mechanism::{GeometryError, Leg, Mechanism, SixHardpoint};

use super::{Design, Kind, Part, Spread, on_circle, point};
use crate::dice::Dice;
use crate::rigid::Rigid;

const LEGS: usize = 6;
/// Per leg: platform point, base point, zero of the length.
const PER_LEG: usize = 7;
/// The least that the joints of a usual machine hold its platform, over its workspace, and of one that works near a
/// singularity.
const USUAL: f64 = 0.04;
const NEAR_SINGULAR: [f64; 2] = [0.003, 0.02];

struct Hexapod {
    /// Length of each leg at home, by the design.
    lengths: [f64; LEGS],
    arm: f64,
}

impl Kind for Hexapod {
    fn name(&self) -> &'static str {
        "six-hardpoint"
    }

    fn parts(&self) -> Vec<Part> {
        let leg = (0..3).map(Part::Platform).chain((0..3).map(Part::Base)).chain([Part::ZeroLength]);
        let leg: Vec<Part> = leg.collect();
        leg.iter().copied().cycle().take(LEGS * PER_LEG).collect()
    }

    fn joints(&self, values: &[f64], pose: &Rigid) -> Option<Vec<f64>> {
        let leg = |v: &[f64]| (pose.place(&point(v, 0)) - point(v, 3)).norm() - v[6];
        Some(values.chunks(PER_LEG).map(leg).collect())
    }

    /// The smallest singular value of the lines of the legs, moments over the radius of the platform.
    fn held(&self, values: &[f64], pose: &Rigid) -> f64 {
        let mut lines = Matrix6::zeros();
        for (k, v) in values.chunks(PER_LEG).enumerate() {
            let arm = pose.turn * point(v, 0);
            let along = (pose.at + arm - point(v, 3)).normalize();
            let moment = arm.cross(&along) / self.arm;
            for axis in 0..3 {
                lines[(k, axis)] = along[axis];
                lines[(k, 3 + axis)] = moment[axis];
            }
        }
        lines.determinant().signum() * lines.singular_values().min()
    }

    fn build(&self, values: &[f64], home: &Rigid, spread: &Spread) -> Result<Box<dyn Mechanism>, GeometryError> {
        let leg = |(v, length): (&[f64], &f64)| Leg {
            platform: point(v, 0),
            base: point(v, 3),
            length: *length,
            length_offset: v[6],
            stroke: None,
        };
        let legs: Vec<Leg> = values.chunks(PER_LEG).zip(&self.lengths).map(leg).collect();
        let tolerance = Some((spread.anchor, spread.length));
        Ok(Box::new(SixHardpoint::new("audited hexapod", &legs, Some(home.pose()), tolerance)?))
    }
}

/// A hexapod whose legs lean in pairs, as usual: 6-6, or with joints that meet in pairs.
pub(super) fn draw(dice: &mut Dice) -> Option<Design> {
    (0..100).find_map(|_| {
        let base_half = if dice.chance(0.2) { 0.0 } else { dice.uniform(5.0, 25.0) };
        let platform_half = if dice.chance(0.2) { 0.0 } else { dice.uniform(5.0, 25.0) };
        let angles = [base_half, 60.0 - platform_half];
        let ratio = dice.uniform(0.4, 1.1);
        let rise = dice.uniform(0.5, 1.5);
        made(dice, angles, ratio, rise, 0.0, |least, _| least > USUAL)
    })
}

/// One whose legs are nearly parallel, between joints on nearly similar hexagons, or all lean one way round.
pub(super) fn draw_near_singular(dice: &mut Dice) -> Option<Design> {
    (0..2000).find_map(|_| {
        let base_half = dice.uniform(8.0, 25.0);
        let (platform_half, twist) = match dice.chance(0.5) {
            true => (base_half + dice.sign() * dice.uniform(0.5, 6.0), 0.0),
            false => (60.0 - base_half - dice.uniform(0.0, 10.0), dice.uniform(55.0, 88.0)),
        };
        let ratio = dice.uniform(0.6, 1.1);
        let rise = dice.uniform(0.5, 1.2);
        made(dice, [base_half, platform_half], ratio, rise, twist, |least, home| {
            least > NEAR_SINGULAR[0] && home < NEAR_SINGULAR[1]
        })
    })
}

/// The machine of these angles, if the design is sound: `accepted` gets the least that it is held over the workspace,
/// and how well it is held at home.
fn made(
    dice: &mut Dice,
    [base_half, platform_half]: [f64; 2],
    ratio: f64,
    rise: f64,
    twist: f64,
    accepted: impl Fn(f64, f64) -> bool,
) -> Option<Design> {
    let size = dice.log_uniform(0.1, 3.0);
    let arm = ratio * size;
    let (up, jitter) = (dice.sign(), if dice.chance(0.5) { dice.uniform(0.0, 0.03) * size } else { 0.0 });
    // Frames of drawings are not always in the plane of the joints.
    let sunk = if dice.chance(0.3) { dice.uniform(-0.2, 0.2) * size } else { 0.0 };
    let first = if dice.chance(0.5) { 0.0 } else { dice.uniform(-60.0, 60.0) };
    let home = Rigid::shifted(Vector3::new(0.0, 0.0, up * rise * size - sunk));
    let (mut values, mut lengths) = (Vec::with_capacity(LEGS * PER_LEG), [0.0; LEGS]);
    for (k, length) in lengths.iter_mut().enumerate() {
        let pair = first + 120.0 * (k / 2) as f64;
        let side = if k % 2 == 0 { -1.0 } else { 1.0 };
        let a = on_circle(arm, pair + side * platform_half + twist, sunk) + dice.in_cube(jitter);
        let b = on_circle(size, pair + side * base_half, 0.0) + dice.in_cube(jitter);
        *length = (home.place(&a) - b).norm();
        values.extend(a.iter().chain(b.iter()).chain([&0.0]));
    }
    let kind = Hexapod { lengths, arm };
    let (shift, turn) = (dice.log_uniform(0.01, 0.15) * size, dice.log_uniform(1.0, 15.0).to_radians());
    let mut half: [f64; 6] = std::array::from_fn(|k| if k < 3 { shift } else { turn });
    half.iter_mut().for_each(|h| *h *= dice.uniform(0.5, 1.0));
    let at_home = kind.held(&values, &home);
    for _ in 0..8 {
        let least = least_held(&kind, &values, &home, &half, at_home.signum());
        if accepted(least, at_home.abs()) {
            return Some(Design::new(kind, values, home, half, size, arm));
        }
        half.iter_mut().for_each(|h| *h *= 0.7);
    }
    None
}

/// The least over the corners of the workspace; negative where it reaches the other side.
fn least_held(kind: &Hexapod, values: &[f64], home: &Rigid, half: &[f64; 6], side: f64) -> f64 {
    let corner = |bits: usize| {
        let u: [f64; 6] = std::array::from_fn(|k| if bits >> k & 1 == 1 { half[k] } else { -half[k] });
        let at = home.moved(&Vector3::new(u[0], u[1], u[2]), &Vector3::new(u[3], u[4], u[5]));
        side * kind.held(values, &at)
    };
    (0..64).map(corner).fold(f64::INFINITY, f64::min)
}
