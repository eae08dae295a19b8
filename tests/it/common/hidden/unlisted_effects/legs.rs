//! Habits of one leg, and of the base: with temperature, elevation, azimuth, time, length or travel.

use rand::{Rng, RngExt};
use std::f64::consts::TAU;

use super::super::effects::{At, CENTRE_OF_MASS, MASS, axial_forces, sign};
use super::super::hexapod::{Disturbance, HOME_LENGTH, State};
use super::super::run::{Run, angle, direction, normal};
use super::UnlistedEffect;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Habit {
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

/// The habit of a number, from 0.
pub(super) fn draw<R: Rng + ?Sized>(which: usize, leg: usize, run: &Run, rng: &mut R) -> UnlistedEffect {
    let number = leg + 1;
    let habit = shape(which, leg, run, rng);
    let covariates = match &habit {
        Habit::Latch { .. } => vec![format!("temp_leg{number}"), "temp_legs".to_owned()],
        Habit::Cable(_) => vec!["azimuth".to_owned()],
        Habit::Pitch { .. } => vec![format!("length_leg{number}")],
        Habit::Cycles { .. } => vec!["time".to_owned()],
        Habit::SoftLeg | Habit::ElevationStep(_) => vec!["elevation".to_owned()],
        Habit::Travel => vec![format!("travel_leg{number}")],
        Habit::QuadraticBase => vec!["temp_base".to_owned()],
        Habit::Loose(_) => Vec::new(),
    };
    let of_base = habit == Habit::QuadraticBase;
    let drawn = UnlistedEffect::acting(super::Habit::Legs(habit)).over(&covariates);
    // A base that grows lowers the platform.
    if of_base { drawn.seen_in(&["z"]) } else { drawn.at_leg(leg) }
}

fn shape<R: Rng + ?Sized>(which: usize, leg: usize, run: &Run, rng: &mut R) -> Habit {
    match which {
        0 => {
            let threshold = run.mean_of_legs[leg] + rng.random_range(-1.0..1.0);
            Habit::Latch { threshold, width: rng.random_range(0.3..0.8) }
        }
        1 => {
            let weight = direction(3, rng);
            let harmonics = [1.0, 2.0, 3.0].map(|order| (order, angle(rng)));
            Habit::Cable(std::array::from_fn(|k| (harmonics[k].0, harmonics[k].1, weight[k])))
        }
        2 => {
            let pitch = rng.random_range(2e-3..4e-3);
            Habit::Pitch { pitch, phase: angle(rng) }
        }
        3 => Habit::Cycles { cycles: rng.random_range(4.0..11.0), phase: angle(rng) },
        4 => Habit::SoftLeg,
        5 => Habit::ElevationStep(rng.random_range(40_f64..70.0).to_radians()),
        6 => Habit::Travel,
        7 => Habit::QuadraticBase,
        _ => Habit::Loose((0..run.len()).map(|_| normal(rng)).collect()),
    }
}

impl Habit {
    pub(super) fn disturb(&self, leg: Option<usize>, size: f64, at: &At<'_>, state: &State, out: &mut Disturbance) {
        if let Some(leg) = leg {
            out.leg[leg] += size * self.of_leg(leg, at, state);
        } else {
            let warm = at.run.rows[at.k].temp_base - at.run.mean_of_base;
            (0..6).for_each(|i| out.base[i] += at.base[i] * (size * warm * warm / HOME_LENGTH));
        }
    }

    /// What it adds to its leg, µm.
    fn of_leg(&self, leg: usize, at: &At<'_>, state: &State) -> f64 {
        let row = &at.run.rows[at.k];
        match self {
            Self::Latch { threshold, width } => ((row.temp_legs[leg] - threshold) / width).tanh(),
            Self::Cable(harmonics) => harmonics.iter().map(|(m, phase, a)| a * (m * row.azimuth + phase).sin()).sum(),
            Self::Pitch { pitch, phase } => (TAU * row.commanded[leg] / pitch + phase).sin(),
            Self::Cycles { cycles, phase } => (TAU * cycles * at.run.elapsed(at.k) + phase).sin(),
            // Newtons over a thousand.
            Self::SoftLeg => 1e-3 * axial_forces(state, MASS, CENTRE_OF_MASS, row.gravity())[leg],
            Self::ElevationStep(at_elevation) => f64::from(u8::from(row.elevation >= *at_elevation)),
            Self::Travel => {
                let travel = row.commanded[leg] - row.before[leg];
                (travel / 0.01).powi(2) * sign(travel)
            }
            Self::QuadraticBase => 0.0,
            Self::Loose(errors) => errors[at.k],
        }
    }
}
