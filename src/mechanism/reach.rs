//! Whether a mechanism comes from home to a pose without being taken apart.

use super::{Mechanism, characteristic_length, consistent};
use crate::conditions::Conditions;
use crate::pose::Pose;

/// Longest steps of the way: turns, rad, and shifts, in sizes of the mechanism.
const TURN: f64 = 0.035;
const SHIFT: f64 = 0.02;
/// Steps at most; a pose that is farther is out of every reach.
const MOST: f64 = 5000.0;
/// Poses that differ by less, rad and in sizes of the mechanism, are one.
const SAME: f64 = 1e-6;

/// True if the joints lead the platform from home to `pose`: along the straight way, which turns about one axis, forward
/// kinematics follows every step.
///
/// Inverse kinematics alone does not see a singularity between the two. Beyond one, the same joints hold another pose: the
/// platform stays in the assembly in which it was put together, and does not come to the one that was meant.
pub fn is_reached(mechanism: &dyn Mechanism, pose: &Pose) -> bool {
    let (c, at, home) = (mechanism.values(), Conditions::unknown(), mechanism.home());
    let size = characteristic_length(mechanism);
    let way = home.motion_to(pose);
    let (shift, turn) = (way.fixed_rows::<3>(0).norm() / size, way.fixed_rows::<3>(3).norm());
    let steps = (shift / SHIFT).max(turn / TURN).ceil().max(1.0);
    // Also where a number is not finite.
    if !(steps <= MOST) {
        return false;
    }
    let mut reached = home;
    for step in 1..=steps as usize {
        let between = home.moved(&(way * (step as f64 / steps)));
        let Ok((wanted, joints)) = consistent(mechanism, c, &between, &at) else { return false };
        let Ok(found) = mechanism.forward(c, &joints, &at, &reached) else { return false };
        let off = wanted.motion_to(&found);
        if !(off.fixed_rows::<3>(0).norm() <= SAME * size && off.fixed_rows::<3>(3).norm() <= SAME) {
            return false;
        }
        reached = found;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::{Leg, SixHardpoint};
    use nalgebra::Vector3;

    /// A hexapod whose legs meet nearly in pairs, 0.4 m high.
    fn hexapod() -> SixHardpoint {
        let at = |radius: f64, degrees: f64| {
            let angle = degrees.to_radians();
            Vector3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
        };
        let home = Pose::from_coordinates(&[0.0, 0.0, 0.4, 0.0, 0.0, 0.0]);
        let leg = |k: usize| {
            let (corner, side) = (120.0 * (k / 2) as f64, if k.is_multiple_of(2) { 1.0 } else { -1.0 });
            let (platform, base) = (at(0.2, corner - side * 10.0), at(0.3, corner - side * 50.0));
            Leg { platform, base, length: (home.place(&platform) - base).norm(), length_offset: 0.0, stroke: None }
        };
        SixHardpoint::new("hexapod", &(0..6).map(leg).collect::<Vec<_>>(), Some(home), None).unwrap()
    }

    #[test]
    fn poses_beyond_a_singularity_are_not_reached() {
        let hexapod = hexapod();
        for (q, reached) in [
            ([0.0, 0.0, 0.4, 0.0, 0.0, 0.0], true),
            ([0.05, -0.05, 0.42, 10.0, -15.0, 20.0], true),
            ([0.0, 0.0, 0.4, 0.0, 0.0, 60.0], true),
            ([0.0, 0.0, 0.4, 0.0, 0.0, 100.0], false),
            ([0.0, 0.0, 0.4, 0.0, 0.0, -175.0], false),
            ([0.0, 0.0, -0.4, 0.0, 0.0, 0.0], false),
            ([0.0, 0.0, f64::NAN, 0.0, 0.0, 0.0], false),
        ] {
            let mut si = q;
            si[3..].iter_mut().for_each(|v| *v = v.to_radians());
            assert_eq!(is_reached(&hexapod, &Pose::from_coordinates(&si)), reached, "{q:?}");
        }
    }
}
