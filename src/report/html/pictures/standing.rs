//! Where the parts of a mechanism stand, in its base frame.

use nalgebra::Vector3;

use super::drawing::centre;
use crate::measurement::Frames;
use crate::mechanism::{Body, Mechanism};
use crate::pose::Pose;

/// A mechanism at home in its base frame, wherever the instrument stood.
#[derive(Clone, Debug)]
pub(in crate::report::html) struct Standing {
    /// Points of the base by leg.
    pub(super) base: Vec<(usize, Vector3<f64>)>,
    /// Points of the platform by leg, platform frame.
    pub(super) platform: Vec<(usize, Vector3<f64>)>,
    /// Pose of the platform at home.
    pub(super) home: Pose,
    /// Origin of the instrument's frame.
    pub(super) instrument: Vector3<f64>,
}

impl Standing {
    /// A mechanism whose base and target are at `frames` in the frames of its poses.
    pub(in crate::report::html) fn of(mechanism: &dyn Mechanism, frames: &Frames) -> Self {
        let (mut base, mut platform) = (points(mechanism, Body::Base), points(mechanism, Body::Platform));
        // The points of a mounted mechanism are those of its drawing.
        if mechanism.mounting().is_none() {
            let back = frames.base.inverse();
            base.iter_mut().for_each(|(_, p)| *p = back.place(p));
            platform.iter_mut().for_each(|(_, p)| *p = frames.target.place(p));
        }
        let home = frames.platform(&mechanism.home());
        Self { base, platform, home, instrument: frames.base.inverse().position }
    }

    /// The same, seen from an instrument in whose frame the base is at `base`.
    pub(in crate::report::html) fn seen_from(self, base: &Pose) -> Self {
        Self { instrument: base.inverse().position, ..self }
    }

    /// The centre of the platform points, platform frame.
    pub(super) fn centre(&self) -> Vector3<f64> {
        centre(self.platform.iter().map(|(_, p)| p))
    }
}

/// Points of a body by leg: those of the parameters, or the platform points that are known without being identified.
fn points(mechanism: &dyn Mechanism, body: Body) -> Vec<(usize, Vector3<f64>)> {
    let identified = body.points(mechanism, mechanism.values());
    match body {
        Body::Platform if identified.is_empty() => mechanism.platform_points().into_iter().enumerate().collect(),
        _ => identified,
    }
}
