//! Files: mechanism files (TOML, URDF), measurements and pose lists (CSV), and how output reaches the disk.
//!
//! * [`Machine`] is a mechanism file: the mechanism, and what else is known about it (workspace, noise,
//!   targets). Units are named in the file; everything is SI once it is read.
//! * [`read_measurement`], [`read_poses`] and [`read_conditions`] read CSV whose column names carry the unit.
//! * [`Outputs`] writes files whole or not at all.
//!
//! Errors name the file, the place in it, the value and what to do ([`FileError`]).

mod column;
mod document;
mod effects;
mod error;
mod extension;
mod joint_columns;
mod kinds;
mod machine;
mod measurement_file;
mod mechanism_reader;
mod outputs;
mod plane;
mod planned;
mod pose_file;
mod positioner;
mod questions;
mod readings;
mod states;
mod surroundings;
mod table;
mod time;
mod urdf;
mod writer;

pub use document::{
    ActuatorSection, CableEntry, HomeSection, LegEntry, MechanismDocument, MountingSection, NoiseSection,
    PlatformSection, TargetEntry, ToleranceSection, WorkspaceSection,
};
pub use error::FileError;
pub use extension::{EffectEntry, OffsetSection, SensorEntry};
pub use machine::Machine;
pub use measurement_file::{Measurement, read_measurement};
pub use outputs::Outputs;
pub use plane::PlaneSection;
pub use planned::{PlannedConditions, read_conditions};
pub use pose_file::{ListedPose, PoseList, read_parameter_errors, read_pose_list, read_poses};
pub use urdf::{Finding, FindingKind, HomeJoint, UrdfFiles, UrdfOptions, WrittenMechanism};
pub use writer::{CsvTable, number};
