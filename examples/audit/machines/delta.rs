//! Six rods on three carriages.

use nalgebra::Vector3;
use paracal::mechanism::kinds::{LinearDelta, Rod, Tolerances};
use paracal::mechanism::{GeometryError, Mechanism};

use super::{Design, Kind, Part, Spread, on_circle, point};
use crate::dice::Dice;
use crate::rigid::Rigid;

/// Per rod: platform point, base point, length; behind all rods the zeros of the carriages.
const PER_ROD: usize = 7;
const RODS: usize = 6 * PER_ROD;

/// The rails are vertical.
struct Delta;

impl Delta {
    /// Where the carriage of a rod stands, above the platform.
    fn carriage(v: &[f64], pose: &Rigid) -> Option<f64> {
        let reach = pose.place(&point(v, 0)) - point(v, 3);
        let rest = v[6] * v[6] - reach.x * reach.x - reach.y * reach.y;
        (rest > 0.0).then(|| reach.z + rest.sqrt())
    }
}

impl Kind for Delta {
    fn name(&self) -> &'static str {
        "linear-delta"
    }

    fn parts(&self) -> Vec<Part> {
        let rod = (0..3).map(Part::Platform).chain((0..3).map(Part::Base)).chain([Part::Length]);
        let rod: Vec<Part> = rod.collect();
        rod.iter().copied().cycle().take(RODS).chain([Part::ZeroUnknown; 3]).collect()
    }

    fn joints(&self, values: &[f64], pose: &Rigid) -> Option<Vec<f64>> {
        let carriage = |(pair, zero): (&[f64], &f64)| Some(Self::carriage(&pair[..PER_ROD], pose)? - zero);
        values[..RODS].chunks(2 * PER_ROD).zip(&values[RODS..]).map(carriage).collect()
    }

    fn follows(&self) -> &[usize] {
        &[3, 4, 5]
    }

    /// How far apart the two rods of a carriage would have it.
    fn misses(&self, values: &[f64], pose: &Rigid) -> Vec<f64> {
        let miss = |pair: &[f64]| {
            let [first, second] = [&pair[..PER_ROD], &pair[PER_ROD..]].map(|rod| Self::carriage(rod, pose));
            first.zip(second).map_or(f64::NAN, |(a, b)| a - b)
        };
        values[..RODS].chunks(2 * PER_ROD).map(miss).collect()
    }

    /// Where a carriage counts from is a matter of where its rods begin.
    fn build(&self, values: &[f64], home: &Rigid, spread: &Spread) -> Result<Box<dyn Mechanism>, GeometryError> {
        let rod = |(k, v): (usize, &[f64])| Rod {
            platform: point(v, 0),
            base: point(v, 3) + Vector3::z() * values[RODS + k / 2],
            length: v[6],
            carriage: k / 2,
            rail: Vector3::z(),
            stroke: None,
        };
        let rods: Vec<Rod> = values[..RODS].chunks(PER_ROD).enumerate().map(rod).collect();
        let tolerances = Tolerances { anchor: spread.anchor, length: spread.length, angle: spread.angle };
        Ok(Box::new(LinearDelta::new("audited delta", &rods, home.pose(), Some(tolerances))?))
    }
}

/// A printer with rods that are parallel in pairs.
pub(super) fn draw(dice: &mut Dice) -> Option<Design> {
    let size = dice.log_uniform(0.1, 1.0);
    let (arm, apart) = (dice.uniform(0.15, 0.3) * size, dice.uniform(0.1, 0.2) * size);
    let rod = dice.uniform(1.4, 2.0) * size;
    let sunk = dice.uniform(0.0, 0.15) * size;
    let mut values = Vec::new();
    for k in 0..6 {
        let degrees = 90.0 + 120.0 * (k / 2) as f64;
        let aside = on_circle(if k % 2 == 0 { apart } else { -apart }, degrees - 90.0, 0.0);
        let a = on_circle(arm, degrees, sunk) + aside;
        let b = on_circle(size, degrees, 0.0) + aside;
        values.extend(a.iter().chain(b.iter()).chain([&rod]));
    }
    values.extend([0.0; 3]);
    let home = Rigid::shifted(Vector3::new(0.0, 0.0, dice.uniform(0.2, 0.8) * size));
    let stroke = dice.log_uniform(0.05, 0.45) * size;
    let half = [stroke, stroke, stroke * dice.uniform(0.5, 1.0), 0.0, 0.0, 0.0];
    Some(Design::new(Delta, values, home, half, size, arm + apart))
}
