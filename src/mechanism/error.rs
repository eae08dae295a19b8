//! Errors of geometries and kinematics.

use thiserror::Error;

use crate::solve::NewtonError;

/// A geometry that is no mechanism.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum GeometryError {
    /// Not six legs.
    #[error("a six-hardpoint mechanism has six legs, found {found}")]
    LegCount {
        /// How many were found.
        found: usize,
    },
    /// A coordinate or length is NaN or infinite.
    #[error("leg {leg}: {what} is not a finite number ({value})")]
    NotFinite {
        /// Leg, from 1.
        leg: usize,
        /// Which number.
        what: String,
        /// Its value.
        value: f64,
    },
    /// A leg length is zero or negative.
    #[error("leg {leg}: the length must be positive, found {length} m")]
    Length {
        /// Leg, from 1.
        leg: usize,
        /// The length found, m.
        length: f64,
    },
    /// A stroke whose ends are not in order.
    #[error("leg {leg}: the stroke [{from}, {to}] m is not an interval of positive lengths")]
    Stroke {
        /// Leg, from 1.
        leg: usize,
        /// Lower end, m.
        from: f64,
        /// Upper end, m.
        to: f64,
    },
    /// Two legs share an anchor without saying so.
    #[error(
        "legs {first} and {second} have the same {body} point ({x}, {y}, {z}) m; \
         correct one of them, or state `shared_anchors = true` if the legs really meet there"
    )]
    EqualAnchors {
        /// First leg, from 1.
        first: usize,
        /// Second leg, from 1.
        second: usize,
        /// `platform` or `base`.
        body: &'static str,
        /// Coordinates of the point, m.
        x: f64,
        /// Coordinates of the point, m.
        y: f64,
        /// Coordinates of the point, m.
        z: f64,
    },
    /// The mechanism is singular at home: the legs do not hold the platform.
    #[error(
        "the mechanism is singular at home (condition {condition:.1e}): its legs do not hold the platform; \
         check the anchors and the home pose"
    )]
    SingularHome {
        /// Condition of `J₁` with angles scaled by the platform radius.
        condition: f64,
    },
    /// No home pose fits the lengths.
    #[error("no home pose fits the leg lengths: {0}; state [home] or correct the lengths")]
    Home(KinematicsError),
    /// The loops of a closure-defined mechanism do not close at home.
    #[error("the loops do not close at home: {0}; correct home or the dimensions")]
    ClosureAtHome(Box<KinematicsError>),
    /// An outline that contradicts itself.
    #[error("{0}")]
    Outline(String),
    /// A closure equation depends on a column although the closure says that it does not.
    #[error(
        "closure equation {row} depends on {column} (derivative {value:.3e} at home), but `Closure::depends` says that it \
         does not"
    )]
    HiddenDependence {
        /// Equation, from 1.
        row: usize,
        /// Parameter or joint.
        column: String,
        /// The derivative.
        value: f64,
    },
    /// Anything else, for mechanisms of a consumer.
    #[error("{0}")]
    Other(String),
    /// A vector of parameters has the wrong length.
    #[error("expected {expected} parameters, found {found}")]
    ParameterCount {
        /// Number of parameters of the mechanism.
        expected: usize,
        /// Number found.
        found: usize,
    },
}

/// A pose or a set of joints that the kinematics cannot serve.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum KinematicsError {
    /// The joints lead to no pose that is connected with the start.
    #[error(
        "the joints are out of reach: from the starting pose only {percent:.1} % of the way can be followed ({cause})"
    )]
    OutOfReach {
        /// How far the joints could be followed from those of the start, %.
        percent: f64,
        /// Error that ended the last attempt.
        cause: NewtonError,
    },
    /// `J₁` has no inverse: the platform can move while the joints stand still.
    #[error("singular pose: with its joints locked the platform is not held (pivot ratio {pivot_ratio:.1e})")]
    Singular {
        /// Smallest over largest pivot of `J₁`.
        pivot_ratio: f64,
    },
    /// A joint, parameter or pose is NaN or infinite.
    #[error("{what} is not a finite number")]
    NotFinite {
        /// Which input.
        what: String,
    },
    /// A joint has no coordinate for the pose.
    #[error("joint {joint} has no coordinate for this pose: {reason}")]
    NoInverse {
        /// Joint name.
        joint: String,
        /// Why not.
        reason: String,
    },
    /// The loops do not close.
    #[error(
        "no joints close the loops at this pose (the best attempt misses by {residual:.1e} m); take a pose nearer to home"
    )]
    NoRoot {
        /// Largest closure residual of the best attempt, m.
        residual: f64,
    },
    /// The loops close only beyond a dead point of a joint.
    #[error("the loops close at this pose only on a different branch from home; take a pose nearer to home")]
    OtherBranch,
    /// Wrong number of joints.
    #[error("expected {expected} joint coordinates, found {found}")]
    JointCount {
        /// Joints of the mechanism.
        expected: usize,
        /// Joints given.
        found: usize,
    },
}
