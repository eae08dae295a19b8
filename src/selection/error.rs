//! Errors of a selection.

use thiserror::Error;

use crate::mechanism::KinematicsError;

/// Poses that cannot be selected.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SelectionError {
    /// Whitened rows need the noise.
    #[error("--scaling whitened needs [noise] in the mechanism file; state it, or use --scaling paper")]
    NoNoise,
    /// Whitened columns need tolerances.
    #[error(
        "--scaling whitened needs [tolerance] in the mechanism file ({parameter} has none); state it, or use --scaling paper"
    )]
    NoTolerance {
        /// A parameter without one.
        parameter: String,
    },
    /// No candidate can be measured.
    #[error(
        "none of {tried} candidate poses can be measured: {unreachable} cannot be reached, {outside} need a joint outside its \
         stroke, {ill} are near a singularity; make the workspace smaller, or correct strokes and home"
    )]
    NoCandidate {
        /// Candidates that were tried.
        tried: usize,
        /// Those without joints, or on the other side of a singularity.
        unreachable: usize,
        /// Those with a joint outside its stroke.
        outside: usize,
        /// Those with a condition number beyond the limit.
        ill: usize,
    },
    /// A list or a draw gave fewer poses than are to be selected.
    #[error(
        "{wanted} poses are requested but only {found} candidates can be measured; ask for fewer poses or offer more \
         candidates"
    )]
    TooFewCandidates {
        /// Poses to select.
        wanted: usize,
        /// Candidates.
        found: usize,
    },
    /// So few poses that the index is zero for every set.
    #[error(
        "{poses} poses give {rows} rows for {directions} parameter directions, so every set has {index} = 0; \
         select at least {least} poses"
    )]
    TooFewPoses {
        /// Poses asked for.
        poses: usize,
        /// Their rows.
        rows: usize,
        /// Directions that the candidates see.
        directions: usize,
        /// The index.
        index: String,
        /// Smallest number of poses with enough rows.
        least: usize,
    },
    /// No pose is wanted beside those given.
    #[error("{given} poses are given and {wanted} requested in total; ask for more than {given} with -n")]
    NothingToSelect {
        /// Poses wanted.
        wanted: usize,
        /// Poses given.
        given: usize,
    },
    /// A pose that was given has no rows.
    #[error("given pose {row}: {cause}")]
    Given {
        /// Row in the file, from 0.
        row: usize,
        /// Why.
        cause: KinematicsError,
    },
    /// No target pose of the predicted error can be reached.
    #[error(
        "none of the {0} target poses can be reached; the predicted pose error needs poses that the mechanism can reach"
    )]
    NoTarget(usize),
    /// An accuracy that no number of poses up to the largest reaches.
    #[error(
        "{poses} poses are predicted to give {position} and {rotation}, which does not meet the requirement; \
         {advice}"
    )]
    Requirement {
        /// Largest number of poses tried.
        poses: usize,
        /// Predicted position error.
        position: String,
        /// Predicted rotation error.
        rotation: String,
        /// What would help, as advice to the user.
        advice: String,
    },
}
