//! Frames that move and instruments that read wrongly: the machine is sound, and the measured pose is not.
//!
//! A frame carries the pose by a rigid motion about the origin of the base. An instrument reads one coordinate wrongly
//! and the others rightly.

use nalgebra::Vector3;
use rand::{Rng, RngExt};
use std::f64::consts::TAU;

use super::super::effects::{At, sign};
use super::super::hexapod::{Disturbance, Geometry, Pose};
use super::super::limits::NOISE;
use super::super::run::{Run, angle, direction};
use super::{COORDINATES, UnlistedEffect};

/// Part of its largest share, in σ, from which on a coordinate is one that the frame moves.
const VISIBLE: f64 = 0.5;
/// Way along an axis to which the unit of an amplitude belongs, m.
const WAY: f64 = 0.01;

/// A shift, µm, and a turn, µrad.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Motion {
    shift: Vector3<f64>,
    turn: Vector3<f64>,
}

/// Of what the motion is a function.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Law {
    /// Proportional to the payload.
    Payload,
    /// A wave over elevation, of so many radians in one of elevation.
    Wave { order: f64, phase: f64 },
    /// It jumps where elevation passes a threshold.
    ElevationStep(f64),
    /// It settles after a part of the run.
    Settling(f64),
    /// The square of the temperature of the platform, whose mount it is.
    TemperatureSquared,
}

/// What a reading has too much, µm or µrad.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Excess {
    /// The guide of the axis is bent: the square of the way along another axis from a place, m.
    Bent { over: usize, from: f64 },
    /// The graduation repeats its error in the angle itself, period in rad.
    Periodic { period: f64, phase: f64 },
    /// A constant from one part of the run to another.
    Between(f64, f64),
    /// Proportional to the payload.
    Payload,
    /// The sense in which the axis came to the row, row by row.
    Play(Vec<f64>),
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Habit {
    Moves {
        motion: Motion,
        law: Law,
    },
    /// A bearing: the axis of the tilt goes round with azimuth, some times in a turn.
    Wobble {
        order: f64,
        phase: f64,
    },
    /// One coordinate is read wrongly.
    Reads {
        coordinate: usize,
        excess: Excess,
    },
}

/// The habit of a frame of a number, from 0.
pub(super) fn draw_frame<R: Rng + ?Sized>(which: usize, rng: &mut R) -> UnlistedEffect {
    let motion = Motion::draw(rng);
    match which {
        0 => {
            let towards: f64 = angle(rng);
            let tilt = Motion { shift: Vector3::zeros(), turn: Vector3::new(towards.cos(), towards.sin(), 0.0) };
            moving(tilt, Law::Payload).over(&["payload"])
        }
        1 => moving(motion, Law::Wave { order: rng.random_range(5.0..8.0), phase: angle(rng) }).over(&["elevation"]),
        2 => {
            let wobble = Habit::Wobble { order: f64::from(rng.random_range(1..4)), phase: angle(rng) };
            UnlistedEffect::acting(super::Habit::Seen(wobble)).over(&["azimuth"]).seen_in(&["x", "y", "rx", "ry"])
        }
        3 => moving(motion, Law::ElevationStep(rng.random_range(40_f64..70.0).to_radians())).over(&["elevation"]),
        4 => moving(motion, Law::Settling(rng.random_range(0.1..0.3))).over(&["time", "row"]).also(&["drift.frame"]),
        _ => moving(motion, Law::TemperatureSquared).over(&["temp_platform"]),
    }
}

fn moving(motion: Motion, law: Law) -> UnlistedEffect {
    let seen = motion.coordinates();
    UnlistedEffect::acting(super::Habit::Seen(Habit::Moves { motion, law })).seen_in(&seen)
}

/// The habit of an instrument of a number, from 0.
pub(super) fn draw_instrument<R: Rng + ?Sized>(which: usize, run: &Run, rng: &mut R) -> UnlistedEffect {
    let reading = |coordinate: usize, excess: Excess| {
        let habit = Habit::Reads { coordinate, excess };
        UnlistedEffect::acting(super::Habit::Seen(habit)).seen_in(&[COORDINATES[coordinate]])
    };
    let any = rng.random_range(0..6);
    match which {
        0 => {
            let (axis, over) = (any % 3, (any % 3 + rng.random_range(1..3)) % 3);
            let from = Geometry::nominal().home().map_or(0.0, |home| home.t[over]) + rng.random_range(-3e-3..3e-3);
            reading(axis, Excess::Bent { over, from }).over(&[COORDINATES[over]])
        }
        1 => {
            let (angular, period) = (3 + any % 3, rng.random_range(0.15_f64..0.4).to_radians());
            reading(angular, Excess::Periodic { period, phase: angle(rng) }).over(&[COORDINATES[angular]])
        }
        2 => {
            let excess = Excess::Between(rng.random_range(0.15..0.4), rng.random_range(0.55..0.85));
            reading(any, excess).over(&["time", "row"]).also(&["step.frame"])
        }
        3 => reading(any, Excess::Payload).over(&["payload"]),
        _ => {
            let own = format!("travel_{}", ["x", "y", "z", "rx", "ry", "rz"][any]);
            let travels: Vec<String> = (1..=6).map(|leg| format!("travel_leg{leg}")).chain([own]).collect();
            reading(any, Excess::Play(senses(run, any))).over(&travels)
        }
    }
}

/// −1 or 1 by the way that a coordinate was commanded to go from the row before.
fn senses(run: &Run, coordinate: usize) -> Vec<f64> {
    let machine = Geometry::nominal();
    let Some(home) = machine.home() else { return vec![0.0; run.len()] };
    let at = |legs: &[f64; 6]| {
        machine.reach(legs, home, |_| Disturbance::default()).map_or(0.0, |pose| pose.coordinates()[coordinate])
    };
    run.rows.iter().map(|row| sign(at(&row.commanded) - at(&row.before))).collect()
}

impl Motion {
    /// A shift or a turn in a random direction.
    fn draw<R: Rng + ?Sized>(rng: &mut R) -> Self {
        let along = Vector3::from_vec(direction(3, rng));
        if rng.random_bool(0.5) {
            Self { shift: along, turn: Vector3::zeros() }
        } else {
            Self { shift: Vector3::zeros(), turn: along }
        }
    }

    /// The coordinates of the platform that it moves most. A turn about the base shifts a platform that stands above it.
    fn coordinates(&self) -> Vec<&'static str> {
        let home = Geometry::nominal().home().map_or_else(Vector3::zeros, |pose| pose.t);
        let shift = (self.shift + self.turn.cross(&home)) / NOISE[0];
        let turn = self.turn / NOISE[1];
        let shares: Vec<f64> = shift.iter().chain(turn.iter()).map(|share| share.abs()).collect();
        let largest = shares.iter().fold(0.0, |a: f64, b| a.max(*b));
        COORDINATES.into_iter().zip(&shares).filter(|(_, share)| **share > VISIBLE * largest).map(|(k, _)| k).collect()
    }
}

impl Law {
    /// About 1 where it acts.
    fn at(&self, at: &At<'_>) -> f64 {
        let row = &at.run.rows[at.k];
        match self {
            Self::Payload => row.payload / 100.0,
            Self::Wave { order, phase } => (order * row.elevation + phase).sin(),
            Self::ElevationStep(threshold) => f64::from(u8::from(row.elevation >= *threshold)),
            Self::Settling(share) => 1.0 - (-at.run.elapsed(at.k) / share).exp(),
            Self::TemperatureSquared => ((row.temp_platform - at.run.mean_of_platform) / 2.0).powi(2),
        }
    }
}

impl Excess {
    /// Of a coordinate of a pose; about 1 where it acts.
    fn of(&self, coordinate: usize, q: &[f64; 6], at: &At<'_>) -> f64 {
        match self {
            Self::Bent { over, from } => ((q[*over] - from) / WAY).powi(2),
            Self::Periodic { period, phase } => (TAU * q[coordinate] / period + phase).sin(),
            Self::Between(from, to) => f64::from(u8::from((*from..*to).contains(&at.run.elapsed(at.k)))),
            Self::Payload => at.run.rows[at.k].payload / 100.0,
            Self::Play(senses) => senses[at.k],
        }
    }
}

impl Habit {
    pub(super) fn carry(&self, size: f64, at: &At<'_>, pose: Pose) -> Pose {
        match self {
            Self::Moves { motion, law } => {
                let by = size * law.at(at);
                pose.carried(motion.shift * by, motion.turn * by)
            }
            Self::Wobble { order, phase } => {
                let (sine, cosine) = (order * at.run.rows[at.k].azimuth + phase).sin_cos();
                pose.carried(Vector3::zeros(), Vector3::new(cosine, sine, 0.0) * size)
            }
            Self::Reads { coordinate, excess } => {
                let mut q = pose.coordinates();
                q[*coordinate] += size * excess.of(*coordinate, &q, at);
                Pose::of(q)
            }
        }
    }
}
