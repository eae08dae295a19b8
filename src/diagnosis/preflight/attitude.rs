//! Ways to write an attitude: twelve orders of three angles, the rotation vector, and quaternions in another order.

use nalgebra::{Quaternion, Rotation3, Unit, UnitQuaternion, Vector3};

use crate::pose::RotationOrder;

/// The axes of three elementary rotations, as factors of the product from left to right: `[2, 1, 0]` is `Rz Ry Rx`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Order {
    axes: [usize; 3],
    /// True if the first column is the angle of the last factor. Of three different axes each column is the angle about its
    /// own axis, and this says nothing.
    reversed: bool,
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl Order {
    /// All orders but the stated one: five of three different axes, and six that come back to their first axis, whose
    /// columns may be the angles from the first factor to the last or from the last to the first.
    pub(crate) fn others(stated: RotationOrder) -> Vec<Self> {
        let stated = match stated {
            RotationOrder::Zyx => [2, 1, 0],
            RotationOrder::Xyz => [0, 1, 2],
        };
        let mut all = Vec::new();
        for first in 0..3 {
            for second in (0..3).filter(|k| *k != first) {
                let third = 3 - first - second;
                let axes = [first, second, third];
                if axes != stated {
                    all.push(Self { axes, reversed: false });
                }
                let proper = [first, second, first];
                all.extend([false, true].map(|reversed| Self { axes: proper, reversed }));
            }
        }
        all
    }

    /// The rotation that three columns of angles, rad, state.
    pub(crate) fn rotation(self, angles: &[f64]) -> Rotation3<f64> {
        let proper = self.axes[0] == self.axes[2];
        let angle = |factor: usize| match (proper, self.reversed) {
            (false, _) => angles[self.axes[factor]],
            (true, false) => angles[factor],
            (true, true) => angles[2 - factor],
        };
        let turn = |factor: usize| {
            let axis = Unit::new_unchecked(Vector3::ith(self.axes[factor], 1.0));
            Rotation3::from_axis_angle(&axis, angle(factor))
        };
        turn(0) * turn(1) * turn(2)
    }

    /// `R = Ry Rx Rz: intrinsic y-x-z, extrinsic z-x-y`.
    pub(crate) fn text(self) -> String {
        let names = self.axes.map(|k| AXES[k]);
        let mut back = names;
        back.reverse();
        let order = format!(
            "R = R{} R{} R{} (intrinsic {}, extrinsic {})",
            names[0],
            names[1],
            names[2],
            names.join("-"),
            back.join("-")
        );
        match (self.axes[0] == self.axes[2], self.reversed) {
            (false, _) => order,
            (true, false) => format!("{order}, the first column being the angle of the leftmost rotation"),
            (true, true) => format!("{order}, the first column being the angle of the rightmost rotation"),
        }
    }
}

/// The quaternion whose scalar part was written in the last of four columns (or, if `first`, in the second), where it was
/// read from the first.
pub(crate) fn permuted(read: &Rotation3<f64>, first: bool) -> Rotation3<f64> {
    let q = UnitQuaternion::from_rotation_matrix(read);
    let (w, x, y, z) = (q.w, q.i, q.j, q.k);
    let meant = if first { Quaternion::new(x, y, z, w) } else { Quaternion::new(z, w, x, y) };
    UnitQuaternion::from_quaternion(meant).to_rotation_matrix()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::PoseConvention;

    #[test]
    fn the_stated_orders_are_among_the_twelve() {
        let angles = [0.3, -0.4, 0.9];
        for (stated, other) in [(RotationOrder::Zyx, RotationOrder::Xyz), (RotationOrder::Xyz, RotationOrder::Zyx)] {
            let orders = Order::others(stated);
            assert_eq!(orders.len(), 17);
            let convention = PoseConvention { order: other, ..Default::default() };
            let meant = convention.rotation(&Vector3::from(angles));
            let close = |o: &&Order| (o.rotation(&angles).matrix() - meant.matrix()).norm() < 1e-14;
            assert_eq!(orders.iter().filter(close).count(), 1);
        }
    }

    /// The four numbers x, y, z, w under a header w, x, y, z.
    #[test]
    fn a_permuted_quaternion_is_put_back() {
        let meant = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.5);
        let read = UnitQuaternion::from_quaternion(Quaternion::new(meant.i, meant.j, meant.k, meant.w));
        let back = permuted(&read.to_rotation_matrix(), false);
        assert!((back.matrix() - meant.to_rotation_matrix().matrix()).norm() < 1e-12);
    }
}
