//! Are the identified values possible for a part that came from the workshop?

use nalgebra::Vector3;

use crate::measurement::Frames;
use crate::mechanism::{Body, Mechanism, ParameterRole, ParameterSpec};
use crate::pose::{Pose, fit_rigid_motion};
use crate::units::Dimension;

/// A parameter that deviates more than the workshop can explain.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Implausible {
    /// Parameter.
    pub name: String,
    /// Deviation from its start after the rigid motions are taken out, SI.
    pub deviation: f64,
    /// Its tolerance, SI.
    pub tolerance: f64,
    /// Dimension of both.
    pub dimension: Dimension,
}

/// Rigid motions and leg offsets, which are convention, and the deviations that remain.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Plausibility {
    /// Pose of the base in the tracker's frame, the best rigid motion of the base points.
    pub base: Pose,
    /// Pose of the target's frame on the platform, from the best rigid motion of the platform points.
    pub target: Pose,
    /// Offset of each joint: true minus commanded coordinate, against the start, SI.
    pub leg_offsets: Vec<f64>,
    /// Parameters beyond four tolerances after that.
    pub implausible: Vec<Implausible>,
}

impl Plausibility {
    /// The same for a mechanism that is mounted in these frames.
    pub(crate) fn seen_from(mut self, frames: &Frames) -> Self {
        self.base = frames.base.compose(&self.base);
        self.target = self.target.compose(&frames.target);
        self
    }
}

/// Deviations up to this many tolerances are plausible.
const LIMIT: f64 = 4.0;

/// Takes the eighteen directions that are convention out of the identified values (two rigid motions and the leg
/// offsets) and compares the rest with the tolerances.
pub fn plausibility(mechanism: &dyn Mechanism, values: &[f64]) -> Plausibility {
    let start = mechanism.values();
    let specs = mechanism.parameters();
    let mut implausible = Vec::new();
    let mut motions = [Pose::identity(); 2];
    for (motion, body) in motions.iter_mut().zip([Body::Base, Body::Platform]) {
        let from: Vec<(usize, Vector3<f64>)> = body.points(mechanism, start);
        let to = body.points(mechanism, values);
        let only = |points: &[(usize, Vector3<f64>)]| points.iter().map(|(_, p)| *p).collect::<Vec<_>>();
        *motion = fit_rigid_motion(&only(&from), &only(&to)).unwrap_or_default();
        let back = motion.inverse();
        for (k, spec) in specs.iter().enumerate() {
            let Some((leg, axis)) = body.coordinate(spec.role) else { continue };
            let Some((_, point)) = to.iter().find(|(l, _)| *l == leg) else { continue };
            note(&mut implausible, spec, back.place(point)[axis] - start[k]);
        }
    }
    for (k, spec) in specs.iter().enumerate() {
        let judged = matches!(
            spec.role,
            ParameterRole::JointScale { .. } | ParameterRole::LegDimension { .. } | ParameterRole::Direction { .. }
        );
        if judged {
            note(&mut implausible, spec, values[k] - start[k]);
        }
    }
    let offset = |k: usize| matches!(specs[k].role, ParameterRole::JointOffset { .. });
    let leg_offsets = (0..specs.len()).filter(|k| offset(*k)).map(|k| values[k] - start[k]).collect();
    Plausibility { base: motions[0], target: motions[1].inverse(), leg_offsets, implausible }
}

fn note(implausible: &mut Vec<Implausible>, spec: &ParameterSpec, deviation: f64) {
    if let Some(tolerance) = spec.tolerance.filter(|t| deviation.abs() > LIMIT * t) {
        implausible.push(Implausible { name: spec.name.clone(), deviation, tolerance, dimension: spec.dimension });
    }
}
