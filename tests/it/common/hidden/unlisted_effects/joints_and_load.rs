//! Habits of joints and screws, which go with the pose, and of legs under the payload.
//!
//! What is linear in the tilt of a leg is a joint in another place, which the parameters of the machine contain. What is
//! left of a joint that is built otherwise is of second order, or has a threshold.

use nalgebra::{Rotation3, Vector3};
use rand::{Rng, RngExt};

use super::super::effects::{At, PAYLOAD_CENTRE, axial_forces, sign};
use super::super::hexapod::{Disturbance, HOME_LENGTH, State};
use super::super::run::direction;
use super::{COORDINATES, UnlistedEffect};

/// Tilt of a leg, twist of a leg and length to which the unit of an amplitude belongs, rad and m.
const TILT: f64 = 0.01;
const TWIST: f64 = 0.005;
const LENGTH: f64 = 0.005;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Habit {
    /// The leg gives way beyond a payload, kg.
    PayloadStep(f64),
    /// All legs soften under load: their compliance is proportional to the payload.
    Softening,
    /// The axes of the universal joint at the platform miss each other: a tilt about one of them lifts the leg.
    Universal { axis: Vector3<f64> },
    /// The centre of the joint at the platform goes sideways, across the tilt that the leg has about an axis.
    Eccentric { axis: Vector3<f64> },
    /// The screw turns with the twist of its leg, but for a slack, rad.
    Slack(f64),
    /// The screw is bent beyond a length over that at home, m.
    BentEnd(f64),
}

/// The habit of a number, from 0.
pub(super) fn draw<R: Rng + ?Sized>(which: usize, leg: usize, rng: &mut R) -> UnlistedEffect {
    let acting = |habit| UnlistedEffect::acting(super::Habit::Joints(habit));
    let axis = Vector3::from_vec(direction(3, rng));
    match which {
        0 => acting(Habit::PayloadStep(75.0)).at_leg(leg).over(&["payload"]),
        1 => acting(Habit::Softening).over(&["payload", "elevation"]).also(&["compliance.payload"]),
        2 => acting(Habit::Universal { axis }).at_leg(leg).over(&COORDINATES).also(&["joint.pivot_shift"]),
        3 => acting(Habit::Eccentric { axis }).at_leg(leg).over(&COORDINATES),
        4 => {
            let slack = Habit::Slack(rng.random_range(1e-3..3e-3));
            acting(slack).at_leg(leg).over(&COORDINATES[3..]).also(&["joint.screw_coupling"])
        }
        _ => {
            let bent = Habit::BentEnd(rng.random_range(2e-3..8e-3));
            acting(bent).at_leg(leg).over(&[format!("length_leg{}", leg + 1)]).also(&["length.quadratic"])
        }
    }
}

impl Habit {
    pub(super) fn disturb(&self, leg: Option<usize>, size: f64, at: &At<'_>, state: &State, out: &mut Disturbance) {
        let Some(leg) = leg else {
            (0..6).for_each(|i| out.leg[i] += size * softening(i, at, state));
            return;
        };
        if let Self::Eccentric { axis } = self {
            let (along, across) = lateral(axis, &at.rest[leg]);
            out.platform[leg] += across * (size * tilt(leg, at, state).dot(&along) / TILT.powi(2));
        } else {
            out.leg[leg] += size * self.of_leg(leg, at, state);
        }
    }

    /// What it adds to its leg, µm.
    fn of_leg(&self, leg: usize, at: &At<'_>, state: &State) -> f64 {
        let row = &at.run.rows[at.k];
        match self {
            Self::PayloadStep(threshold) => f64::from(u8::from(row.payload > *threshold)),
            Self::Universal { axis } => {
                let about = tilt(leg, at, state).dot(&lateral(axis, &at.rest[leg]).0);
                0.5 * (about / TILT).powi(2)
            }
            Self::Slack(slack) => {
                let twist = Rotation3::from_matrix_unchecked(state.pose.r).scaled_axis().dot(&state.along[leg]);
                sign(twist) * (twist.abs() - slack).max(0.0) / TWIST
            }
            Self::BentEnd(from) => (row.commanded[leg] - HOME_LENGTH - from).max(0.0) / LENGTH,
            Self::Softening | Self::Eccentric { .. } => 0.0,
        }
    }
}

/// The force of the payload on a leg, a hundred newtons, times the payload in quintals.
fn softening(leg: usize, at: &At<'_>, state: &State) -> f64 {
    let row = &at.run.rows[at.k];
    let forces = axial_forces(state, row.payload, PAYLOAD_CENTRE, row.gravity());
    1e-2 * forces[leg] * row.payload / 100.0
}

/// The direction of a leg as the platform sees it, less that at home.
fn tilt(leg: usize, at: &At<'_>, state: &State) -> Vector3<f64> {
    state.pose.r.transpose() * state.along[leg] - at.rest[leg]
}

/// Two directions across a leg and across each other, the first as near to an axis as can be.
fn lateral(axis: &Vector3<f64>, leg: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let first = (axis - leg * leg.dot(axis)).normalize();
    (first, leg.cross(&first))
}
