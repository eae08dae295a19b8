//! What is measured, and with which noise.

use std::sync::Arc;

use nalgebra::Vector3;
use paracal::measurement::{
    Contact, ContactReading, DataRow, Dataset, MeasurementModel, Plane, PlaneContact, PoseMeasurement, PoseReading,
    Sample, TargetMeasurement, TargetPoint,
};
use paracal::pose::PoseConvention;

use crate::dice::Dice;
use crate::effects::conditions;
use crate::machines::Design;
use crate::rigid::Rigid;
use crate::situations::{Flaw, Situation};
use crate::trial::Stand;

/// What is measured of the platform.
#[derive(Clone, Debug)]
pub(crate) enum Reading {
    /// Some of the six coordinates of a pose.
    Coordinates([bool; 6]),
    /// Points at these places of the platform, and whether the places are known.
    Targets(Vec<Vector3<f64>>, bool),
    /// The height of a point of the platform over the plane `normal · p = distance`, and whether that plane is known.
    Heights { normal: Vector3<f64>, distance: f64, tip: Vector3<f64>, known: bool },
}

impl Reading {
    pub(crate) fn draw(design: &Design, dice: &mut Dice) -> Self {
        let points = if design.has_platform { [0.08, 0.08, 0.04] } else { [0.0; 3] };
        match dice.pick(&[0.6, 0.1, 0.1, points[0], points[1], points[2]]) {
            0 => Self::Coordinates([true; 6]),
            1 => Self::Coordinates([true, true, true, false, false, false]),
            2 => {
                let mut measured = [true; 6];
                let missing = dice.count(1, 3);
                dice.some_of(6, missing).into_iter().for_each(|k| measured[k] = false);
                Self::Coordinates(measured)
            }
            3 => Self::Targets(places(design, dice), true),
            4 => Self::Targets(places(design, dice), false),
            _ => {
                let tilt = dice.in_cube(0.3);
                let normal = Vector3::new(tilt.x, tilt.y, 1.0).normalize();
                let distance = dice.uniform(-1.0, 1.0) * design.size;
                Self::Heights { normal, distance, tip: dice.in_cube(0.2 * design.size), known: dice.chance(0.5) }
            }
        }
    }

    pub(crate) fn name(&self) -> String {
        match self {
            Self::Coordinates([true, true, true, true, true, true]) => "full poses".into(),
            Self::Coordinates([true, true, true, false, false, false]) => "positions".into(),
            Self::Coordinates(measured) => {
                let names = ["x", "y", "z", "rx", "ry", "rz"];
                let seen: Vec<&str> = names.iter().zip(measured).filter(|(_, m)| **m).map(|(n, _)| *n).collect();
                format!("poses of {}", seen.join(" "))
            }
            Self::Targets(places, known) => {
                format!("{} {} targets", places.len(), if *known { "known" } else { "unknown" })
            }
            Self::Heights { known, .. } => {
                format!("heights over {} plane", if *known { "a known" } else { "an unknown" })
            }
        }
    }

    pub(crate) fn is_full(&self) -> bool {
        matches!(self, Self::Coordinates([true, true, true, true, true, true]))
    }

    /// True if the frame of the instrument can be found from it.
    pub(crate) fn registers(&self) -> bool {
        matches!(self, Self::Coordinates([true, true, true, ..]) | Self::Targets(..))
    }

    /// True if the target may sit anywhere on the platform.
    pub(crate) fn has_target_frame(&self) -> bool {
        matches!(self, Self::Coordinates(_))
    }

    /// True if all angles of the platform follow from one reading.
    pub(crate) fn sees_rotation(&self) -> bool {
        matches!(self, Self::Coordinates([_, _, _, true, true, true]) | Self::Targets(..))
    }

    /// True if the position of the platform follows from one reading.
    pub(crate) fn sees_position(&self) -> bool {
        self.registers()
    }
}

/// Three to six places that do not lie on a line.
fn places(design: &Design, dice: &mut Dice) -> Vec<Vector3<f64>> {
    let count = dice.count(3, 6);
    let (first, turn) = (dice.uniform(0.0, 360.0), 360.0 / count as f64);
    let place = |k: usize| {
        let (s, c) = (first + turn * k as f64).to_radians().sin_cos();
        Vector3::new(c, s, 0.0) * (0.8 * design.arm) + dice.in_cube(0.2 * design.arm)
    };
    (0..count).map(place).collect()
}

/// True noise of a campaign, and what is stated of it.
pub(crate) struct Noise {
    /// 1σ of a coordinate, m.
    pub(crate) position: f64,
    /// 1σ of an angle, rad.
    pub(crate) rotation: f64,
    /// Degrees of freedom of Student's distribution, if it is that.
    tails: Option<usize>,
    /// What is stated: the noise of a coordinate and of an angle.
    stated: paracal::measurement::Noise,
}

impl Noise {
    pub(crate) fn draw(situation: &Situation, design: &Design, dice: &mut Dice) -> Self {
        let position = dice.log_uniform(1e-6, 3e-5) * design.size;
        let rotation = position / design.arm * dice.log_uniform(0.3, 3.0);
        let tails = (situation.flaw == Flaw::Student).then(|| dice.count(3, 4));
        let stated = match situation.flaw {
            Flaw::NoiseUnknown => paracal::measurement::Noise::unknown(design.arm),
            _ => paracal::measurement::Noise::stated(position / situation.noise, rotation / situation.noise),
        };
        Self { position, rotation, tails, stated }
    }

    fn draw_one(&self, dice: &mut Dice) -> f64 {
        match self.tails {
            Some(freedom) => dice.student(freedom),
            None => dice.normal(),
        }
    }

    fn shift(&self, dice: &mut Dice) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.position * self.draw_one(dice))
    }
}

/// How far off gross rows are, in units of the noise.
const GROSS: [f64; 2] = [30.0, 3000.0];

/// A campaign: what is measured how, and what goes wrong in it.
pub(crate) struct Campaign<'a> {
    pub(crate) reading: &'a Reading,
    pub(crate) convention: &'a PoseConvention,
    pub(crate) noise: &'a Noise,
    pub(crate) design: &'a Design,
    /// Rows that are grossly wrong.
    pub(crate) gross: Vec<usize>,
    /// True if instrument or target are not in the frames of the drawing.
    pub(crate) elsewhere: bool,
}

impl Campaign<'_> {
    /// The data: samples with their joints, and the poses at which the instrument saw the target.
    pub(crate) fn dataset(&self, samples: &[Stand], mut seen: Vec<Rigid>, dice: &mut Dice) -> Dataset {
        let noise = self.noise;
        for row in &self.gross {
            let off = dice.log_uniform(GROSS[0], GROSS[1]) * noise.position;
            let [shift, turn] = [off, off / self.design.arm].map(|size| dice.in_cube(1.0).normalize() * size);
            seen[*row] = seen[*row].moved(&shift, &turn);
        }
        let model: Arc<dyn MeasurementModel> = match self.reading {
            Reading::Coordinates(measured) => {
                let [p, r] = [noise.stated.position, noise.stated.rotation];
                let read = |pose: &Rigid| PoseReading {
                    values: self.coordinates(pose, measured, dice),
                    measured: *measured,
                    sigma: [p, p, p, r, r, r],
                };
                Arc::new(PoseMeasurement::new(*self.convention, seen.iter().map(read).collect()))
            }
            Reading::Targets(places, known) => Arc::new(targets(&seen, places, *known, noise, dice)),
            Reading::Heights { normal, distance, tip, known } => {
                let read = |pose: &Rigid| ContactReading {
                    height: Some(normal.dot(&pose.place(tip)) - distance + noise.position * noise.draw_one(dice)),
                    sigma: noise.stated.position,
                };
                let readings = seen.iter().map(read).collect();
                let plane = Plane::new(normal, *distance).unwrap_or(Contact::default().plane);
                Arc::new(PlaneContact::new(Contact { plane, tip: *tip, known: *known }, readings))
            }
        };
        let sample = |(row, stand): (usize, &Stand)| Sample {
            id: None,
            row: DataRow(row),
            joints: stand.joints.clone(),
            conditions: conditions(stand.warmer),
        };
        Dataset::new(samples.iter().enumerate().map(sample).collect(), model, noise.stated)
    }

    /// Six numbers with noise: of each angle as it is written or, where all three are measured in any frame, of the
    /// attitude, as the angles may be near their singularity there.
    fn coordinates(&self, pose: &Rigid, measured: &[bool; 6], dice: &mut Dice) -> [f64; 6] {
        let noise = self.noise;
        let shift = noise.shift(dice);
        let turn = Vector3::from_fn(|_, _| noise.rotation * noise.draw_one(dice));
        let of_attitude = self.elsewhere && measured[3..].iter().all(|m| *m);
        let mut written = pose.written(self.convention);
        if of_attitude {
            let turned = pose.moved(&Vector3::zeros(), &turn).written(self.convention);
            written[3..].copy_from_slice(&turned[3..]);
        }
        for k in 0..3 {
            written[k] += shift[k];
            written[3 + k] += if of_attitude { 0.0 } else { turn[k] };
        }
        written
    }
}

fn targets(seen: &[Rigid], places: &[Vector3<f64>], known: bool, noise: &Noise, dice: &mut Dice) -> TargetMeasurement {
    let target = |(k, place): (usize, &Vector3<f64>)| TargetPoint {
        name: format!("p{}", k + 1),
        platform: known.then_some(*place),
    };
    let mut readings = Vec::with_capacity(seen.len());
    for pose in seen {
        let read = places.iter().map(|place| {
            let p = pose.place(place) + noise.shift(dice);
            [Some(p.x), Some(p.y), Some(p.z)]
        });
        readings.push(read.collect());
    }
    let sigma = vec![[noise.stated.position; 3]; seen.len()];
    TargetMeasurement::new(places.iter().enumerate().map(target).collect(), readings, sigma)
}
