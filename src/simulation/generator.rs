//! Mechanisms with known errors, and what a tracker would measure of them.

use std::sync::Arc;

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::conditions::Conditions;
use crate::effect::{ActiveEffect, EffectContext, seen};
use crate::measurement::{DataRow, Dataset, Noise, PoseMeasurement, PoseReading, Sample};
use crate::mechanism::{ForwardQuery, KinematicsError, Mechanism, ParameterSpec, characteristic_length};
use crate::pose::{Pose, PoseConvention};
use crate::units::Dimension;

/// One simulated sample.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SimulatedSample {
    /// Joints as they are recorded: commanded, or read where more joints than the pose needs settle among each other;
    /// with reading noise if there is any.
    pub joints: Vec<f64>,
    /// Where the true mechanism went.
    pub truth: Pose,
    /// Where the instrument sees it, without noise.
    pub seen: Pose,
    /// Measured coordinates, m and rad.
    pub measured: [f64; 6],
}

/// A normal number with standard deviation `sd`.
pub(crate) fn normal<R: Rng + ?Sized>(rng: &mut R, sd: f64) -> f64 {
    let z: f64 = StandardNormal.sample(rng);
    sd * z
}

/// Parameters of a mechanism with a normal error on each: of standard deviation `sd` (m) for lengths and `sd` over the
/// [`characteristic_length`] for angles; of its tolerance for other dimensions and where `sd` is `None` (none where it
/// has no tolerance).
pub fn draw_parameters<R: Rng + ?Sized>(mechanism: &dyn Mechanism, sd: Option<f64>, rng: &mut R) -> Vec<f64> {
    let size = characteristic_length(mechanism);
    let drawn = |(spec, value): (&ParameterSpec, &f64)| {
        let asked = match spec.dimension {
            Dimension::Length => sd,
            Dimension::Angle => sd.map(|sd| sd / size),
            _ => None,
        };
        value + normal(rng, asked.or(spec.tolerance).unwrap_or(0.0))
    };
    mechanism.parameters().iter().zip(mechanism.values()).map(drawn).collect()
}

/// Commands each pose by the nominal mechanism, lets the true one go there, and measures.
///
/// # Errors
/// Index of the pose and [`KinematicsError`] if the nominal mechanism has no joints for it, or the true one no
/// pose for the joints.
pub fn simulate<R: Rng + ?Sized>(
    nominal: &dyn Mechanism,
    truth: &dyn Mechanism,
    poses: &[Pose],
    convention: &PoseConvention,
    noise: &Noise,
    rng: &mut R,
) -> Result<Vec<SimulatedSample>, (usize, KinematicsError)> {
    let run: Vec<Command> = poses.iter().map(|p| Command { pose: *p, state: Conditions::unknown() }).collect();
    simulate_run(nominal, truth, &run, None, convention, noise, rng)
}

/// A pose to command, and the state in which it is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Command {
    /// The pose.
    pub pose: Pose,
    /// State of the machine meanwhile; its place in the run is filled in.
    pub state: Conditions,
}

/// Effects on the measurement, and what they measure from.
#[derive(Clone, Copy, Debug)]
pub struct Instrument<'a> {
    /// The nominal mechanism and what stands around it.
    pub context: &'a EffectContext<'a>,
    /// The effects; those that act on the mechanism are left out.
    pub effects: &'a [ActiveEffect],
}

/// Simulates a run, one row after the other, in states that the true mechanism may depend on, as seen through an
/// instrument. The first row is approached from the home of the nominal mechanism.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_run<R: Rng + ?Sized>(
    nominal: &dyn Mechanism,
    truth: &dyn Mechanism,
    run: &[Command],
    instrument: Option<&Instrument<'_>>,
    convention: &PoseConvention,
    noise: &Noise,
    rng: &mut R,
) -> Result<Vec<SimulatedSample>, (usize, KinematicsError)> {
    let commands: Vec<Vec<f64>> = run
        .iter()
        .enumerate()
        .map(|(k, c)| nominal.inverse(nominal.values(), &c.pose, &Conditions::unknown()).map_err(|e| (k, e)))
        .collect::<Result<_, _>>()?;
    let home = nominal.inverse(nominal.values(), &nominal.home(), &Conditions::unknown()).ok();
    let mut states: Vec<Conditions> = run.iter().map(|c| c.state.clone()).collect();
    Conditions::put_in_run(&mut states, commands.clone(), home.as_deref());
    let query = |((command, joints), at): ((&Command, _), _)| ForwardQuery::new(joints, at, command.pose);
    let queries: Vec<ForwardQuery<'_>> =
        run.iter().zip(commands.iter().map(Vec::as_slice)).zip(&states).map(query).collect();
    let reached = truth.forward_batch(truth.values(), &queries);
    let mut samples = Vec::with_capacity(run.len());
    for (k, ((went, mut joints), at)) in reached.into_iter().zip(commands).zip(&states).enumerate() {
        let went = went.map_err(|e| (k, e))?;
        if truth.equations() > 6 {
            // More joints than the pose needs cannot all follow their commands: readings are those of the pose that was
            // reached.
            joints = truth.inverse(truth.values(), &went, at).map_err(|e| (k, e))?;
        }
        let seen = instrument.map_or(went, |i| seen(i.effects, i.context, &joints, &went, at));
        let mut measured = convention.coordinates(&seen);
        for (c, value) in measured.iter_mut().enumerate() {
            *value += normal(rng, if c < 3 { noise.position } else { noise.rotation });
        }
        if noise.joint > 0.0 {
            for joint in &mut joints {
                *joint += normal(rng, noise.joint);
            }
        }
        samples.push(SimulatedSample { joints, truth: went, seen, measured });
    }
    Ok(samples)
}

/// The simulated samples as full poses with this noise.
pub fn as_dataset(samples: &[SimulatedSample], convention: &PoseConvention, noise: &Noise) -> Dataset {
    let (p, r) = (noise.position, noise.rotation);
    let sigma = [p, p, p, r, r, r];
    let readings = samples.iter().map(|s| PoseReading { values: s.measured, measured: [true; 6], sigma }).collect();
    let listed = samples
        .iter()
        .enumerate()
        .map(|(row, s)| Sample { row: DataRow(row), joints: s.joints.clone(), ..Sample::default() })
        .collect();
    Dataset::new(listed, Arc::new(PoseMeasurement::new(*convention, readings)), *noise)
}
