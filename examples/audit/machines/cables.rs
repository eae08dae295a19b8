//! A plate in a vertical plane on four cables, which are wound on drums.

use nalgebra::Vector3;
use paracal::mechanism::kinds::{Cable, PlanarCables, Segment, Tolerances};
use paracal::mechanism::{GeometryError, Mechanism};

use super::{Design, Kind, Part, Spread};
use crate::dice::Dice;
use crate::rigid::Rigid;

const CABLES: usize = 4;
/// Per cable: two coordinates of the platform point, two of the anchor, its zero, the radius of its drum.
const PER_CABLE: usize = 6;

struct Cables {
    home: Rigid,
    /// How often each cable runs to the plate.
    times: [usize; CABLES],
}

impl Cables {
    fn length(v: &[f64], pose: &Rigid) -> f64 {
        (pose.place(&Vector3::new(v[0], v[1], 0.0)) - Vector3::new(v[2], v[3], 0.0)).norm()
    }
}

impl Kind for Cables {
    fn name(&self) -> &'static str {
        "planar-cables"
    }

    fn parts(&self) -> Vec<Part> {
        use Part::{Base, Length, Platform, ZeroLength};
        let cable = [Platform(0), Platform(1), Base(0), Base(1), ZeroLength, Length];
        cable.iter().copied().cycle().take(CABLES * PER_CABLE).collect()
    }

    /// Drums stand at zero at home.
    fn joints(&self, values: &[f64], pose: &Rigid) -> Option<Vec<f64>> {
        let drum = |(v, times): (&[f64], &usize)| {
            ((Self::length(v, pose) - Self::length(v, &self.home)) * *times as f64 - v[4]) / v[5]
        };
        Some(values.chunks(PER_CABLE).zip(&self.times).map(drum).collect())
    }

    fn build(&self, values: &[f64], home: &Rigid, spread: &Spread) -> Result<Box<dyn Mechanism>, GeometryError> {
        let segment =
            |v: &[f64]| Segment { platform: Vector3::new(v[0], v[1], 0.0), base: Vector3::new(v[2], v[3], 0.0) };
        let cable = |(k, v): (usize, &[f64])| Cable {
            segments: vec![k; self.times[k]],
            build_up: None,
            drum: Some(v[5]),
            offset: v[4],
            stroke: None,
        };
        let segments: Vec<Segment> = values.chunks(PER_CABLE).map(segment).collect();
        let cables: Vec<Cable> = values.chunks(PER_CABLE).enumerate().map(cable).collect();
        let tolerances = Tolerances { anchor: spread.anchor, length: spread.length, angle: spread.angle };
        Ok(Box::new(PlanarCables::new("audited cables", &segments, &cables, home.pose(), Some(tolerances))?))
    }
}

/// A plate between four anchors; the last cable may run over a pulley on the plate.
pub(super) fn draw(dice: &mut Dice) -> Option<Design> {
    let size = dice.log_uniform(0.3, 3.0);
    let plate = dice.uniform(0.1, 0.2) * size;
    let mut values = Vec::new();
    for [x, y] in [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]] {
        let anchor = [x, y].map(|v| v * size * dice.uniform(0.8, 1.1));
        let corner = [x * plate, y * plate * 0.6];
        values.extend(corner.iter().chain(&anchor).chain(&[0.0, dice.uniform(0.03, 0.06) * size]));
    }
    let home = Rigid::shifted(Vector3::new(dice.uniform(-0.1, 0.1) * size, dice.uniform(-0.1, 0.1) * size, 0.0));
    let times = [1, 1, 1, if dice.chance(0.5) { 2 } else { 1 }];
    let (shift, turn) = (dice.log_uniform(0.05, 0.4) * size, dice.log_uniform(2.0, 15.0).to_radians());
    let half = [shift, shift, 0.0, 0.0, 0.0, turn];
    let design = Design::new(Cables { home, times }, values, home, half, size, plate);
    Some(Design { finer: 0.1, ..design })
}
