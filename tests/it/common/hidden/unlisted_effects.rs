//! Nine effects that no catalogue lists: real habits of machines, for which the honest answer is "unknown".
//!
//! Each names the covariates that an answer may give for it. One has none: a leg whose length is uncertain.

use rand::{Rng, RngExt};
use std::f64::consts::TAU;

use super::effects::{At, CENTRE_OF_MASS, Influence, MASS, axial_forces, sign};
use super::hexapod::{Disturbance, HOME_LENGTH, State};
use super::run::{Run, angle, direction, normal};

/// What kind of stranger, with the shape that was drawn for it.
#[derive(Clone, Debug, PartialEq)]
enum Shape {
    /// The leg latches when its temperature passes a threshold, within a width, K.
    Latch { threshold: f64, width: f64 },
    /// A cable drags: harmonics of azimuth (order, phase, weight).
    Cable([(f64, f64, f64); 3]),
    /// A cyclic error of another pitch, m.
    Pitch { pitch: f64, phase: f64 },
    /// Ventilation: so many cycles in the run.
    Cycles { cycles: f64, phase: f64 },
    /// One leg is softer than the others.
    SoftLeg,
    /// The leg steps at an elevation.
    ElevationStep(f64),
    /// The length error goes with the square of the way from the row before, and with its sign.
    Travel,
    /// The base expands with the square of the temperature.
    QuadraticBase,
    /// A length error of one leg by chance.
    Loose(Vec<f64>),
}

/// An effect outside the catalogue. Its amplitude scales it; 1 is about a micrometre.
#[derive(Clone, Debug, PartialEq)]
pub struct UnlistedEffect {
    pub name: &'static str,
    pub leg: Option<usize>,
    /// Any of these is a right answer.
    pub covariates: Vec<String>,
    pub amplitude: f64,
    shape: Shape,
}

pub const NAMES: [&str; 9] = [
    "latch at a temperature",
    "cable over azimuth",
    "unlisted pitch",
    "cycles in time",
    "soft leg",
    "step at an elevation",
    "travel squared",
    "base quadratic in temperature",
    "loose leg",
];

impl UnlistedEffect {
    /// The stranger of a number, with a random leg and shape.
    pub fn draw<R: Rng + ?Sized>(which: usize, run: &Run, rng: &mut R) -> Self {
        let leg = rng.random_range(0..6);
        let number = leg + 1;
        let own = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let (shape, covariates) = match which {
            0 => {
                let threshold = run.mean_of_legs[leg] + rng.random_range(-1.0..1.0);
                let width = rng.random_range(0.3..0.8);
                (Shape::Latch { threshold, width }, vec![format!("temp_leg{number}"), "temp_legs".to_owned()])
            }
            1 => {
                let weight = direction(3, rng);
                let harmonics = [1.0, 2.0, 3.0].map(|order| (order, angle(rng)));
                let weighted = |k: usize| (harmonics[k].0, harmonics[k].1, weight[k]);
                (Shape::Cable(std::array::from_fn(weighted)), own(&["azimuth"]))
            }
            2 => {
                let pitch = rng.random_range(2e-3..4e-3);
                (Shape::Pitch { pitch, phase: angle(rng) }, vec![format!("length_leg{number}")])
            }
            3 => (Shape::Cycles { cycles: rng.random_range(4.0..11.0), phase: angle(rng) }, own(&["time"])),
            4 => (Shape::SoftLeg, own(&["elevation"])),
            5 => (Shape::ElevationStep(rng.random_range(40_f64..70.0).to_radians()), own(&["elevation"])),
            6 => (Shape::Travel, vec![format!("travel_leg{number}")]),
            7 => (Shape::QuadraticBase, own(&["temp_base"])),
            _ => (Shape::Loose((0..run.len()).map(|_| normal(rng)).collect()), Vec::new()),
        };
        let leg = (shape != Shape::QuadraticBase).then_some(leg);
        Self { name: NAMES[which.min(8)], leg, covariates, amplitude: 1.0, shape }
    }

    /// What it adds to its leg, µm.
    fn of_leg(&self, leg: usize, at: &At<'_>, state: &State) -> f64 {
        let row = &at.run.rows[at.k];
        match &self.shape {
            Shape::Latch { threshold, width } => ((row.temp_legs[leg] - threshold) / width).tanh(),
            Shape::Cable(harmonics) => harmonics.iter().map(|(m, phase, a)| a * (m * row.azimuth + phase).sin()).sum(),
            Shape::Pitch { pitch, phase } => (TAU * row.commanded[leg] / pitch + phase).sin(),
            Shape::Cycles { cycles, phase } => (TAU * cycles * at.run.elapsed(at.k) + phase).sin(),
            // Newtons over a thousand.
            Shape::SoftLeg => 1e-3 * axial_forces(state, MASS, CENTRE_OF_MASS, row.gravity())[leg],
            Shape::ElevationStep(at_elevation) => f64::from(u8::from(row.elevation >= *at_elevation)),
            Shape::Travel => {
                let travel = row.commanded[leg] - row.before[leg];
                (travel / 0.01).powi(2) * sign(travel)
            }
            Shape::QuadraticBase => 0.0,
            Shape::Loose(errors) => errors[at.k],
        }
    }
}

impl Influence for UnlistedEffect {
    fn disturb(&self, at: &At<'_>, state: &State, out: &mut Disturbance) {
        let size = 1e-6 * self.amplitude;
        if let Some(leg) = self.leg {
            out.leg[leg] += size * self.of_leg(leg, at, state);
        } else {
            let warm = at.run.rows[at.k].temp_base - at.run.mean_of_base;
            (0..6).for_each(|i| out.base[i] += at.base[i] * (size * warm * warm / HOME_LENGTH));
        }
    }
}
