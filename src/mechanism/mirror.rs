//! The mirror image of home: legs of the same lengths may hold the platform on the other side of the base.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::{Body, Mechanism, forward_by_closure};
use crate::conditions::Conditions;
use crate::pose::Pose;

/// How far the middle of the platform's points at `pose` is above that of the base's, m.
pub fn height_over_base(mechanism: &dyn Mechanism, pose: &Pose) -> f64 {
    let middle = |body: Body| {
        let points = body.points(mechanism, mechanism.values());
        points.iter().map(|(_, p)| p).sum::<Vector3<f64>>() / points.len() as f64
    };
    pose.place(&middle(Body::Platform)).z - middle(Body::Base).z
}

/// The pose near the mirror image of home in the horizontal plane of the base at which the joints are the same, if it lies on
/// the other side.
pub fn mirrored_home(mechanism: &dyn Mechanism) -> Option<Pose> {
    let (c, at, home) = (mechanism.values(), Conditions::unknown(), mechanism.home());
    let platform = Body::Platform.points(mechanism, c);
    let middle = platform.iter().map(|(_, p)| p).sum::<Vector3<f64>>() / platform.len() as f64;
    // A flat platform is its own mirror image in its plane, so that the mirrored one is only turned.
    let mirror = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0));
    let rotation = Rotation3::from_matrix_unchecked(mirror * home.rotation.matrix() * mirror);
    let across = Vector3::new(0.0, 0.0, 2.0 * height_over_base(mechanism, &home));
    let seed = Pose { position: home.place(&middle) - across - rotation * middle, rotation };
    let joints = mechanism.inverse(c, &home, &at).ok()?;
    let found = forward_by_closure(mechanism, c, &joints, &at, &seed);
    // On the same side it is home itself, or another assembly that nobody means.
    let beyond = |pose: &Pose| height_over_base(mechanism, pose) * height_over_base(mechanism, &home) < 0.0;
    found.ok().filter(beyond)
}
