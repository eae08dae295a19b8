//! The nineteen effects of legged machines, written a second time.
//!
//! Each acts where its equation says: on the length of a leg, on a joint, or on the measured pose. Everything that an
//! equation takes from the machine (directions, arms, forces, lengths) is taken at the true state.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::hexapod::{Disturbance, Geometry, Pose, State};
use super::run::Run;

/// Mass of the platform, kg, its centre and that of the load, m in the platform frame; pitch of the screws, m.
pub const MASS: f64 = 500.0;
pub const CENTRE_OF_MASS: f64 = 0.150;
pub const PAYLOAD_CENTRE: f64 = 0.300;
pub const PITCH: f64 = 5e-3;

/// What a row offers to an effect.
pub struct At<'a> {
    pub run: &'a Run,
    pub k: usize,
    /// Directions of the legs when the machine is at home.
    pub rest: &'a [Vector3<f64>; 6],
    /// Platform joints in the platform frame, base joints in the base frame.
    pub platform: &'a [Vector3<f64>; 6],
    pub base: &'a [Vector3<f64>; 6],
}

/// Whatever is wrong with a machine or with its measurement.
pub trait Influence: Sync {
    /// What it adds to the machine at a state.
    fn disturb(&self, at: &At<'_>, state: &State, out: &mut Disturbance);

    /// The pose that is measured where `pose` is true.
    fn carry(&self, _at: &At<'_>, pose: Pose) -> Pose {
        pose
    }
}

/// Over what an effect is searched for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scan {
    None,
    Leg,
    Row,
    LegAndRow,
}

/// Name, usual size of each parameter (SI) and scan of an effect.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    pub name: &'static str,
    pub scale: &'static [f64],
    pub scan: Scan,
}

const RIGID: &[f64] = &[1e-5; 6];
const fn known(name: &'static str, scale: &'static [f64], scan: Scan) -> Known {
    Known { name, scale, scan }
}

/// The catalogue as the methods page has it.
pub const CATALOGUE: [Known; 19] = [
    known("thermal.legs.uniform", &[1e-5], Scan::None),
    known("thermal.legs.individual", &[1e-5], Scan::None),
    known("thermal.leg.single", &[1e-5], Scan::Leg),
    known("thermal.platform", &[1e-5], Scan::None),
    known("thermal.base", &[1e-5], Scan::None),
    known("scale.common", &[2e-3], Scan::None),
    known("scale.per_leg", &[2e-3; 6], Scan::None),
    known("length.quadratic", &[5e-2; 6], Scan::None),
    known("cyclic.pitch", &[5e-6; 12], Scan::None),
    known("backlash", &[5e-6; 6], Scan::None),
    known("compliance.gravity", &[1e-8], Scan::None),
    known("compliance.payload", &[1e-8], Scan::None),
    known("sag.frame", &[2e-5; 2], Scan::None),
    known("sag.platform", &[1e-5; 2], Scan::None),
    known("joint.pivot_shift", &[2e-2], Scan::None),
    known("drift.frame", RIGID, Scan::None),
    known("drift.leg", &[1e-5], Scan::Leg),
    known("step.frame", RIGID, Scan::Row),
    known("step.leg", &[1e-5], Scan::LegAndRow),
];

/// What is wrong with the readings and not with the machine.
pub const INSTRUMENTS: [Known; 4] = [
    known("thermal.frame", &[1e-6; 6], Scan::None),
    known("instrument.scale", &[1e-3; 3], Scan::None),
    known("instrument.rotation_gain", &[3e-4; 3], Scan::None),
    known("instrument.skew", &[3e-4; 3], Scan::None),
];

/// The entry of a name.
pub fn named(name: &str) -> Option<Known> {
    CATALOGUE.into_iter().chain(INSTRUMENTS).find(|known| known.name == name)
}

/// An effect with values, at a leg (from 0) and a row if it has them.
#[derive(Clone, Debug, PartialEq)]
pub struct Planted {
    pub name: &'static str,
    pub leg: Option<usize>,
    pub row: Option<usize>,
    pub theta: Vec<f64>,
}

impl Planted {
    fn rigid(&self, by: f64) -> (Vector3<f64>, Vector3<f64>) {
        let t = &self.theta;
        (Vector3::new(t[0], t[1], t[2]) * by, Vector3::new(t[3], t[4], t[5]) * by)
    }

    /// The pose that an instrument with wrong factors reads.
    fn misread(&self, pose: Pose) -> Pose {
        let (t, mut q) = (&self.theta, pose.coordinates());
        match self.name {
            "instrument.scale" => (0..3).for_each(|k| q[k] *= 1.0 + t[k]),
            "instrument.rotation_gain" => (0..3).for_each(|k| q[3 + k] *= 1.0 + t[k]),
            "instrument.skew" => {
                q[0] += t[0] * q[1] + t[1] * q[2];
                q[1] += t[2] * q[2];
            }
            _ => return pose,
        }
        Pose::of(q)
    }

    /// 0 before the row of a step, 1 from it on.
    fn after(&self, k: usize) -> f64 {
        if self.row.is_some_and(|row| k >= row) { 1.0 } else { 0.0 }
    }
}

/// Axial forces of the legs that carry a weight at a point of the platform: Gᵀ F = w.
pub fn axial_forces(state: &State, mass: f64, centre: f64, gravity: Vector3<f64>) -> Vector6<f64> {
    let force = gravity * mass;
    let moment = (state.pose.r * Vector3::new(0.0, 0.0, centre)).cross(&force);
    let mut transposed = Matrix6::zeros();
    for i in 0..6 {
        transposed.fixed_view_mut::<3, 1>(0, i).copy_from(&state.along[i]);
        transposed.fixed_view_mut::<3, 1>(3, i).copy_from(&state.arms[i].cross(&state.along[i]));
    }
    let wrench = Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z);
    // Singular only where the machine could not stand; no force then.
    transposed.lu().solve(&wrench).unwrap_or_else(Vector6::zeros)
}

impl Influence for Planted {
    fn disturb(&self, at: &At<'_>, state: &State, out: &mut Disturbance) {
        let (row, theta) = (&at.run.rows[at.k], &self.theta);
        let warmth: [f64; 6] = std::array::from_fn(|i| row.temp_legs[i] - at.run.mean_of_legs[i]);
        let travel = |i: usize| row.commanded[i] - at.run.stage.design.lengths[i];
        let mut legs = |of: &dyn Fn(usize) -> f64| (0..6).for_each(|i| out.leg[i] += of(i));
        let only = |i: usize| if self.leg == Some(i) { theta[0] } else { 0.0 };
        match self.name {
            "thermal.legs.uniform" => {
                let mean = warmth.iter().sum::<f64>() / 6.0;
                legs(&|i| theta[0] * row.commanded[i] * mean);
            }
            "thermal.legs.individual" => legs(&|i| theta[0] * row.commanded[i] * warmth[i]),
            "thermal.leg.single" => legs(&|i| only(i) * row.commanded[i] * warmth[i]),
            "thermal.platform" => {
                let warm = theta[0] * (row.temp_platform - at.run.mean_of_platform);
                (0..6).for_each(|i| out.platform[i] += at.platform[i] * warm);
            }
            "thermal.base" => {
                let warm = theta[0] * (row.temp_base - at.run.mean_of_base);
                (0..6).for_each(|i| out.base[i] += at.base[i] * warm);
            }
            "scale.common" => legs(&|i| theta[0] * travel(i)),
            "scale.per_leg" => legs(&|i| theta[i] * travel(i)),
            "length.quadratic" => legs(&|i| theta[i] * travel(i).powi(2)),
            "cyclic.pitch" => legs(&|i| {
                let (sine, cosine) = (std::f64::consts::TAU * row.commanded[i] / PITCH).sin_cos();
                theta[i] * sine + theta[6 + i] * cosine
            }),
            "backlash" => legs(&|i| 0.5 * theta[i] * sign(row.commanded[i] - row.before[i])),
            "compliance.gravity" => {
                let forces = axial_forces(state, MASS, CENTRE_OF_MASS, row.gravity());
                legs(&|i| theta[0] * forces[i]);
            }
            "compliance.payload" => {
                let forces = axial_forces(state, row.payload, PAYLOAD_CENTRE, row.gravity());
                legs(&|i| theta[0] * forces[i]);
            }
            "sag.platform" => {
                for i in 0..6 {
                    let twice = 2.0 * at.platform[i].y.atan2(at.platform[i].x);
                    let bend = theta[0] * twice.cos() + theta[1] * twice.sin();
                    out.platform[i].z += bend * row.down().z;
                }
            }
            "joint.pivot_shift" => {
                let angle = |i: usize| at.rest[i].cross(&state.along[i]).norm().atan2(at.rest[i].dot(&state.along[i]));
                legs(&|i| theta[0] * angle(i).powi(2));
            }
            "drift.leg" => legs(&|i| only(i) * at.run.elapsed(at.k)),
            "step.leg" => legs(&|i| only(i) * self.after(at.k)),
            _ => {}
        }
    }

    fn carry(&self, at: &At<'_>, pose: Pose) -> Pose {
        let (shift, turn) = match self.name {
            "sag.frame" => {
                let down = at.run.rows[at.k].down();
                (down * self.theta[0], Vector3::z().cross(&down) * self.theta[1])
            }
            "drift.frame" => self.rigid(at.run.elapsed(at.k)),
            "step.frame" => self.rigid(self.after(at.k)),
            "thermal.frame" => self.rigid(at.run.rows[at.k].temp_base - at.run.mean_of_base),
            _ => return self.misread(pose),
        };
        pose.carried(shift, turn)
    }
}

/// −1, 0 or 1.
pub fn sign(v: f64) -> f64 {
    if v == 0.0 { 0.0 } else { v.signum() }
}

/// Noise-free measured coordinates of every row.
pub fn measured(machine: &Geometry, run: &Run, influences: &[&dyn Influence]) -> Option<Vec<[f64; 6]>> {
    let home = run.stage.home_of(machine)?;
    let rest = machine.state(home).along;
    let mut near = home;
    (0..run.len())
        .map(|k| {
            let at = At { run, k, rest: &rest, platform: &machine.platform, base: &machine.base };
            let disturb = |state: &State| {
                let mut out = Disturbance::default();
                influences.iter().for_each(|influence| influence.disturb(&at, state, &mut out));
                out
            };
            near = machine.reach(&run.rows[k].commanded, near, disturb)?;
            Some(influences.iter().fold(near, |pose, influence| influence.carry(&at, pose)).coordinates())
        })
        .collect()
}
