//! Specifications of parameters and joints.

use crate::units::Dimension;

/// An axis of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// x.
    X,
    /// y.
    Y,
    /// z.
    Z,
}

impl Axis {
    /// All three, in order.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// 0, 1 or 2.
    pub fn index(self) -> usize {
        self as usize
    }
}

/// Role of a parameter, by which frames, plausibility, weak directions and effects find what they act on in any
/// mechanism. Legs count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterRole {
    /// A coordinate of the point `aᵢ` where a leg meets the platform, platform frame.
    PlatformPoint {
        /// Leg.
        leg: usize,
        /// Axis of the platform frame.
        axis: Axis,
    },
    /// A coordinate of the point `bᵢ` where a leg meets the base, base frame.
    BasePoint {
        /// Leg.
        leg: usize,
        /// Axis of the base frame.
        axis: Axis,
    },
    /// An offset added to the coordinate of a joint, such as `hᵢ`.
    JointOffset {
        /// Leg.
        leg: usize,
    },
    /// A factor of the coordinate of a joint, such as the radius of a drum.
    JointScale {
        /// Leg.
        leg: usize,
    },
    /// A dimension inside a leg.
    LegDimension {
        /// Leg.
        leg: usize,
    },
    /// An offset of a coordinate of the pose, where the joints are the coordinates themselves.
    PoseOffset {
        /// Coordinate: x, y, z, α, β, γ.
        coordinate: usize,
    },
    /// A small turn of a direction of a leg, rad: the axis of a crank or of a hinge, a rail.
    Direction {
        /// Leg, from 0.
        leg: usize,
    },
    /// Anything else.
    Other,
}

impl ParameterRole {
    /// The leg that the parameter belongs to, if it belongs to one.
    pub fn leg(self) -> Option<usize> {
        match self {
            Self::PlatformPoint { leg, .. }
            | Self::BasePoint { leg, .. }
            | Self::JointOffset { leg }
            | Self::JointScale { leg }
            | Self::LegDimension { leg }
            | Self::Direction { leg } => Some(leg),
            Self::PoseOffset { .. } | Self::Other => None,
        }
    }
}

/// One kinematic parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterSpec {
    /// Name in results: `xA1 … h1 … zB6`.
    pub name: String,
    /// Dimension; values are in SI.
    pub dimension: Dimension,
    /// Value of the design, SI; NaN if there is none.
    pub nominal: f64,
    /// 1σ of manufacture, if it is known.
    pub tolerance: Option<f64>,
    /// Role in the mechanism.
    pub role: ParameterRole,
}

/// One joint coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct JointSpec {
    /// Name of its column in measurement files: `leg1`.
    pub name: String,
    /// Dimension; values are in SI.
    pub dimension: Dimension,
    /// Smallest and largest allowed coordinate, SI.
    pub stroke: Option<[f64; 2]>,
}
