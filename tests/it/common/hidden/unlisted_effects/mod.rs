//! Effects that no catalogue lists: real habits of legs, joints, frames and instruments, for which the honest answer is
//! "unknown".
//!
//! Each keeps the covariates and the coordinates that an answer may give for it, and the names of the catalogue that are
//! physically right as well. One has none of them: a leg whose length is uncertain.

mod frame_and_instrument;
mod joints_and_load;
mod legs;

use rand::{Rng, RngExt};

use super::effects::{At, Influence};
use super::hexapod::{Disturbance, Pose, State};
use super::run::Run;

/// Names of the coordinates of a pose.
pub const COORDINATES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// Legs and base, then joints and load, the frame, the instrument.
pub const NAMES: [&str; 26] = [
    "latch at a temperature",
    "cable over azimuth",
    "unlisted pitch",
    "cycles in time",
    "soft leg",
    "step at an elevation",
    "travel squared",
    "base quadratic in temperature",
    "loose leg",
    "leg jumps with payload",
    "softness with payload squared",
    "joint axes that do not meet",
    "eccentric joint",
    "screw turns after a slack",
    "bent end of a screw",
    "frame tilts with payload",
    "frame bends over elevation",
    "frame wobbles over azimuth",
    "frame jumps at an elevation",
    "frame settles",
    "frame quadratic in temperature",
    "axis bent over another",
    "periodic error of an angle",
    "reading jumps and returns",
    "reading follows payload",
    "play of the instrument",
];

/// Where a stranger acts, with the shape that was drawn for it.
#[derive(Clone, Debug, PartialEq)]
enum Habit {
    Legs(legs::Habit),
    Joints(joints_and_load::Habit),
    Seen(frame_and_instrument::Habit),
}

/// An effect outside the catalogue. Its amplitude scales it; 1 is about a micrometre or a microradian.
#[derive(Clone, Debug, PartialEq)]
pub struct UnlistedEffect {
    pub name: &'static str,
    pub leg: Option<usize>,
    /// Any of these is a right answer.
    pub covariates: Vec<String>,
    /// Coordinates that it moves as they are seen. Any of these is a right answer.
    pub coordinates: Vec<String>,
    /// Effects of the catalogue that are physically right as well.
    pub names: Vec<String>,
    pub amplitude: f64,
    habit: Habit,
}

impl UnlistedEffect {
    /// The stranger of a number, with a random leg and shape.
    pub fn draw<R: Rng + ?Sized>(which: usize, run: &Run, rng: &mut R) -> Self {
        let which = which % NAMES.len();
        let leg = rng.random_range(0..6);
        let drawn = match which {
            0..9 => legs::draw(which, leg, run, rng),
            9..15 => joints_and_load::draw(which - 9, leg, rng),
            15..21 => frame_and_instrument::draw_frame(which - 15, rng),
            _ => frame_and_instrument::draw_instrument(which - 21, run, rng),
        };
        Self { name: NAMES[which], ..drawn }
    }

    /// One that acts at no leg and has no right answers yet.
    fn acting(habit: Habit) -> Self {
        let (covariates, coordinates, names) = (Vec::new(), Vec::new(), Vec::new());
        Self { name: "", leg: None, covariates, coordinates, names, amplitude: 1.0, habit }
    }

    fn at_leg(self, leg: usize) -> Self {
        Self { leg: Some(leg), ..self }
    }

    fn over<N: ToString>(self, covariates: &[N]) -> Self {
        Self { covariates: owned(covariates), ..self }
    }

    fn seen_in<N: ToString>(self, coordinates: &[N]) -> Self {
        Self { coordinates: owned(coordinates), ..self }
    }

    fn also(self, names: &[&str]) -> Self {
        Self { names: owned(names), ..self }
    }
}

fn owned<N: ToString>(names: &[N]) -> Vec<String> {
    names.iter().map(N::to_string).collect()
}

impl Influence for UnlistedEffect {
    fn disturb(&self, at: &At<'_>, state: &State, out: &mut Disturbance) {
        let size = 1e-6 * self.amplitude;
        match &self.habit {
            Habit::Legs(habit) => habit.disturb(self.leg, size, at, state, out),
            Habit::Joints(habit) => habit.disturb(self.leg, size, at, state, out),
            Habit::Seen(_) => {}
        }
    }

    fn carry(&self, at: &At<'_>, pose: Pose) -> Pose {
        let size = 1e-6 * self.amplitude;
        match &self.habit {
            Habit::Seen(habit) => habit.carry(size, at, pose),
            Habit::Legs(_) | Habit::Joints(_) => pose,
        }
    }
}
