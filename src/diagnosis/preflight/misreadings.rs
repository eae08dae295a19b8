//! Ways to misread a file of poses and joints.

use crate::mechanism::Mechanism;
use crate::pose::{Pose, PoseConvention, RotationOrder};
use crate::units::Dimension;

/// Joints and coordinates of the poses, by sample, as they stand in a file.
#[derive(Clone, Debug)]
pub(crate) struct StatedRows {
    pub(crate) joints: Vec<Vec<f64>>,
    pub(crate) poses: Vec<[f64; 6]>,
    pub(crate) convention: PoseConvention,
}

/// One way to read a file otherwise.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Reading {
    /// As it stands.
    AsStated,
    /// A coordinate counts the other way.
    AxisSign(usize),
    /// The rotation is that from base to platform.
    Transposed,
    /// The pose is that of the base seen from the platform.
    Inverse,
    /// The other order of the elementary rotations.
    EulerOrder,
    /// Angles are in this unit times what is stated.
    AngleUnit(&'static str, f64),
    /// Positions (or, if true, lengths of legs) are in this unit times what is stated.
    LengthUnit(&'static str, f64, bool),
    /// Two coordinates change places.
    Swapped(usize, usize),
    /// Columns of legs in another order: leg `i` stands in column `order[i]`.
    LegOrder(Vec<usize>),
    /// All legs count their extension the other way, or one of them.
    LegSign(Option<usize>),
    /// Each pose belongs to the joints of another row.
    RowShift(isize),
}

const NAMES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

impl Reading {
    /// Name in the format.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::AsStated => "as stated",
            Self::AxisSign(_) => "axis-sign",
            Self::Transposed | Self::Inverse => "inverse-pose",
            Self::EulerOrder => "euler-order",
            Self::AngleUnit(..) => "angle-unit",
            Self::LengthUnit(..) => "length-unit",
            Self::Swapped(..) => "axes-swapped",
            Self::LegOrder(_) => "leg-order",
            Self::LegSign(_) => "leg-sign",
            Self::RowShift(_) => "row-shift",
        }
    }

    /// What is wrong, in words.
    pub(crate) fn detail(&self) -> String {
        match self {
            Self::AsStated => "as stated".into(),
            Self::AxisSign(k) => format!("the sign of {} is reversed", NAMES[*k]),
            Self::Transposed => "the rotation is inverted (passive instead of active)".into(),
            Self::Inverse => "the pose is that of the base seen from the platform".into(),
            Self::EulerOrder => "the angles follow the other order of rotations".into(),
            Self::AngleUnit(unit, _) => format!("the angles seem to be in a different unit: {unit}"),
            Self::LengthUnit(unit, _, false) => format!("the positions seem to be in a different unit: {unit}"),
            Self::LengthUnit(unit, _, true) => format!("the leg lengths seem to be in a different unit: {unit}"),
            Self::Swapped(a, b) => format!("the columns of {} and {} are swapped", NAMES[*a], NAMES[*b]),
            Self::LegOrder(order) => {
                let columns: Vec<String> = order.iter().map(|k| (k + 1).to_string()).collect();
                format!("legs 1 to {} are in the columns of legs {}", order.len(), columns.join(", "))
            }
            Self::LegSign(None) => "the legs count their extension in the opposite direction".into(),
            Self::LegSign(Some(leg)) => format!("leg {} counts its extension in the opposite direction", leg + 1),
            Self::RowShift(by) if *by > 0 => "each pose is one row below its joints".into(),
            Self::RowShift(_) => "each pose is one row above its joints".into(),
        }
    }

    /// Those that are tried for a mechanism, except orders of legs.
    pub(crate) fn all(mechanism: &dyn Mechanism) -> Vec<Self> {
        let degree = std::f64::consts::PI / 180.0;
        let mut all: Vec<Self> = (0..6).map(Self::AxisSign).collect();
        all.extend([Self::Transposed, Self::Inverse, Self::EulerOrder]);
        all.extend([
            Self::AngleUnit("rad where deg is stated, or larger by the same factor", 1.0 / degree),
            Self::AngleUnit("deg where rad is stated, or smaller by the same factor", degree),
            Self::AngleUnit("arcsec where deg is stated, or smaller by the same factor", 1.0 / 3600.0),
            Self::AngleUnit("deg where arcsec is stated, or larger by the same factor", 3600.0),
            Self::AngleUnit("mrad where deg is stated, or smaller by the same factor", 1e-3 / degree),
            Self::AngleUnit("1000 times smaller", 1e-3),
            Self::AngleUnit("1000 times larger", 1e3),
        ]);
        let lengths = mechanism.joints().iter().all(|j| j.dimension == Dimension::Length);
        for legs in [false, true] {
            if legs && !lengths {
                continue;
            }
            all.extend([
                Self::LengthUnit("1000 times larger", 1e3, legs),
                Self::LengthUnit("1000 times smaller", 1e-3, legs),
                Self::LengthUnit("in where mm is stated", 25.4, legs),
                Self::LengthUnit("mm where in is stated", 1.0 / 25.4, legs),
            ]);
        }
        all.extend([(0, 1), (0, 2), (1, 2), (3, 4), (3, 5), (4, 5)].map(|(a, b)| Self::Swapped(a, b)));
        all.extend([Self::LegSign(None), Self::RowShift(1), Self::RowShift(-1)]);
        all.extend((0..mechanism.joints().len()).map(|leg| Self::LegSign(Some(leg))));
        all
    }

    /// Joints and pose of a row when the file is read this way; `None` if the row has no partner.
    pub(crate) fn row(&self, table: &StatedRows, home: &[f64], row: usize) -> Option<(Vec<f64>, Pose)> {
        let mut joints = table.joints[row].clone();
        let mut q = table.poses[row];
        let mut convention = table.convention;
        match self {
            Self::AsStated => {}
            Self::AxisSign(k) => q[*k] = -q[*k],
            Self::Transposed | Self::Inverse => {
                let pose = convention.pose(&q);
                let turned = if *self == Self::Inverse {
                    pose.inverse()
                } else {
                    Pose { position: pose.position, rotation: pose.rotation.inverse() }
                };
                return Some((joints, turned));
            }
            Self::EulerOrder => {
                convention.order = match convention.order {
                    RotationOrder::Zyx => RotationOrder::Xyz,
                    RotationOrder::Xyz => RotationOrder::Zyx,
                };
            }
            Self::AngleUnit(_, factor) => q[3..].iter_mut().for_each(|v| *v *= factor),
            Self::LengthUnit(_, factor, false) => q[..3].iter_mut().for_each(|v| *v *= factor),
            Self::LengthUnit(_, factor, true) => joints.iter_mut().for_each(|v| *v *= factor),
            Self::Swapped(a, b) => q.swap(*a, *b),
            Self::LegOrder(order) => joints = order.iter().map(|k| table.joints[row][*k]).collect(),
            Self::LegSign(None) => joints.iter_mut().zip(home).for_each(|(v, h)| *v = 2.0 * h - *v),
            Self::LegSign(Some(leg)) => joints[*leg] = 2.0 * home[*leg] - joints[*leg],
            Self::RowShift(by) => {
                let partner = row.checked_add_signed(*by).filter(|k| *k < table.poses.len())?;
                q = table.poses[partner];
            }
        }
        Some((joints, convention.pose(&q)))
    }
}
