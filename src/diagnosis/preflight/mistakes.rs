//! Mistakes of a reader in the readings of an instrument: signs, units, orders, frames.

use nalgebra::{Rotation3, Vector3};

use crate::diagnosis::preflight::attitude::{Order, permuted};
use crate::diagnosis::preflight::unit_factors::UnitFactor;
use crate::pose::{Pose, PoseConvention, RotationOrder};

/// One mistake, which is undone by reading the numbers otherwise.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Mistake {
    /// A coordinate counts the other way.
    AxisSign(usize),
    /// Two coordinates change places.
    Swapped(usize, usize),
    /// Both the axes and the angles of a left-handed frame: the axis that points the other way.
    Handedness(usize),
    /// Angles are in another unit.
    AngleUnit(UnitFactor),
    /// Positions are in another unit.
    LengthUnit(UnitFactor),
    /// The mechanism file is in another unit, by which positions and lengths of legs are multiplied here.
    FileUnit(UnitFactor),
    /// Another order of the elementary rotations.
    EulerOrder(Order),
    /// The three angles are a rotation vector.
    RotationVector,
    /// The four numbers of the quaternion stand in another order.
    QuaternionOrder(bool),
    /// The rotation is that from base to platform.
    Transposed,
    /// Positions are counted along the axes of the platform.
    PlatformAxes,
    /// The pose is that of the base seen from the platform.
    Inverse,
    /// Each reading belongs to the joints of another row.
    RowShift(isize),
}

const NAMES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

impl Mistake {
    /// All of them, or those that measured points alone can show.
    pub(crate) fn all(convention: RotationOrder, attitudes: bool) -> Vec<Self> {
        let mut all: Vec<Self> = (0..6).map(Self::AxisSign).collect();
        all.extend((0..3).map(Self::Handedness));
        all.extend([(0, 1), (0, 2), (1, 2), (3, 4), (3, 5), (4, 5)].map(|(a, b)| Self::Swapped(a, b)));
        all.extend([Self::Transposed, Self::Inverse, Self::PlatformAxes, Self::RotationVector]);
        all.extend([false, true].map(Self::QuaternionOrder));
        all.extend(Order::others(convention).into_iter().map(Self::EulerOrder));
        all.extend(UnitFactor::angles().into_iter().map(Self::AngleUnit));
        all.extend(UnitFactor::lengths().into_iter().map(Self::LengthUnit));
        all.extend(UnitFactor::lengths().into_iter().map(Self::FileUnit));
        all.extend([1, -1].map(Self::RowShift));
        all.retain(|m| attitudes || m.concerns_points());
        all
    }

    /// Name in the format.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::AxisSign(_) => "axis-sign",
            Self::Swapped(..) => "axes-swapped",
            Self::Handedness(_) => "handedness",
            Self::AngleUnit(_) => "angle-unit",
            Self::LengthUnit(_) => "length-unit",
            Self::FileUnit(_) => "file-unit",
            Self::EulerOrder(_) | Self::RotationVector => "euler-order",
            Self::QuaternionOrder(_) => "quaternion-order",
            Self::Transposed | Self::Inverse => "inverse-pose",
            Self::PlatformAxes => "platform-axes",
            Self::RowShift(_) => "row-shift",
        }
    }

    /// What is wrong, in words.
    pub(crate) fn detail(&self) -> String {
        match self {
            Self::AxisSign(k) => format!("the sign of {} is reversed", NAMES[*k]),
            Self::Swapped(a, b) => format!("the columns of {} and {} are swapped", NAMES[*a], NAMES[*b]),
            Self::Handedness(k) => {
                let angles: Vec<&str> = (0..3).filter(|a| a != k).map(|a| NAMES[3 + a]).collect();
                let turned = angles.join(" and ");
                format!("the frame is left-handed: {} counts the other way, and so do {turned}", NAMES[*k])
            }
            Self::AngleUnit(unit) => format!("the angles seem to be in a different unit: {}", unit.text()),
            Self::LengthUnit(unit) => format!("the positions seem to be in a different unit: {}", unit.text()),
            Self::FileUnit(unit) => {
                format!("the lengths of the mechanism file seem to be in a different unit: {}", unit.text_of_other())
            }
            Self::EulerOrder(order) => format!("the angles follow another order of rotations: {}", order.text()),
            Self::RotationVector => "the three angles are a rotation vector (axis times angle)".into(),
            Self::QuaternionOrder(false) => "the quaternion is written x, y, z, w under a header w, x, y, z".into(),
            Self::QuaternionOrder(true) => "the quaternion is written w, x, y, z under a header x, y, z, w".into(),
            Self::Transposed => "the rotation is inverted (passive instead of active)".into(),
            Self::PlatformAxes => "the positions are counted along the axes of the platform".into(),
            Self::Inverse => "the pose is that of the base seen from the platform".into(),
            Self::RowShift(by) if *by > 0 => "each pose is one row below its joints".into(),
            Self::RowShift(_) => "each pose is one row above its joints".into(),
        }
    }

    /// True if it changes what is known of a point without an attitude.
    fn concerns_points(&self) -> bool {
        match self {
            Self::AxisSign(k) => *k < 3,
            Self::Swapped(a, b) => *a < 3 && *b < 3,
            Self::Handedness(_) | Self::LengthUnit(_) | Self::FileUnit(_) | Self::RowShift(_) => true,
            _ => false,
        }
    }

    /// True if two mistakes may be made together: they are of different kinds, or of different coordinates.
    pub(crate) fn goes_with(&self, other: &Self) -> bool {
        let unit = |m: &Self| matches!(m, Self::LengthUnit(_) | Self::FileUnit(_));
        let attitude = |m: &Self| matches!(m, Self::EulerOrder(_) | Self::RotationVector | Self::QuaternionOrder(_));
        let both = |kind: &dyn Fn(&Self) -> bool| kind(self) && kind(other);
        self != other
            && !both(&unit)
            && !both(&attitude)
            && (self.name() != other.name() || matches!(self, Self::AxisSign(_)))
    }

    /// Six coordinates, m and rad, as they should have been read.
    fn correct(&self, q: &mut [f64; 6]) {
        match self {
            Self::AxisSign(k) => q[*k] = -q[*k],
            Self::Swapped(a, b) => q.swap(*a, *b),
            Self::Handedness(k) => {
                q[*k] = -q[*k];
                (0..3).filter(|a| a != k).for_each(|a| q[3 + a] = -q[3 + a]);
            }
            Self::AngleUnit(unit) => q[3..].iter_mut().for_each(|v| *v *= unit.factor),
            Self::LengthUnit(unit) | Self::FileUnit(unit) => q[..3].iter_mut().for_each(|v| *v *= unit.factor),
            _ => {}
        }
    }
}

/// The pose that six coordinates state when these mistakes are undone.
pub(crate) fn pose_without(mistakes: &[Mistake], convention: &PoseConvention, q: &[f64; 6]) -> Pose {
    let mut q = *q;
    mistakes.iter().for_each(|m| m.correct(&mut q));
    let mut rotation: Rotation3<f64> = convention.rotation(&Vector3::new(q[3], q[4], q[5]));
    for mistake in mistakes {
        rotation = match mistake {
            Mistake::EulerOrder(order) => order.rotation(&q[3..]),
            Mistake::RotationVector => Rotation3::from_scaled_axis(Vector3::new(q[3], q[4], q[5])),
            Mistake::QuaternionOrder(first) => permuted(&rotation, *first),
            _ => rotation,
        };
    }
    if mistakes.contains(&Mistake::Transposed) {
        rotation = rotation.inverse();
    }
    let mut position = Vector3::new(q[0], q[1], q[2]);
    if mistakes.contains(&Mistake::PlatformAxes) {
        position = rotation * position;
    }
    let pose = Pose { position: position - rotation * convention.pivot, rotation };
    if mistakes.contains(&Mistake::Inverse) { pose.inverse() } else { pose }
}

/// The place of a measured point when these mistakes are undone, m.
pub(crate) fn point_without(mistakes: &[Mistake], point: &Vector3<f64>) -> Vector3<f64> {
    let mut q = [point.x, point.y, point.z, 0.0, 0.0, 0.0];
    mistakes.iter().for_each(|m| m.correct(&mut q));
    Vector3::new(q[0], q[1], q[2])
}

/// By how many rows the readings must be shifted, and by what the lengths of legs must be multiplied.
pub(crate) fn shift_and_scale(mistakes: &[Mistake]) -> (isize, f64) {
    mistakes.iter().fold((0, 1.0), |(shift, scale), mistake| match mistake {
        Mistake::RowShift(by) => (*by, scale),
        Mistake::FileUnit(unit) => (shift, unit.factor),
        _ => (shift, scale),
    })
}
