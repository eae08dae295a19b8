//! Files: mechanism files (TOML, URDF), measurements and pose lists (CSV), and how output reaches the disk.
//!
//! * [`Machine`] is a mechanism file: the mechanism, and what else is known about it (workspace, noise,
//!   targets). Units are named in the file; everything is SI once it is read.
//! * [`read_measurement`], [`read_poses`] and [`read_conditions`] read CSV whose column names carry the unit.
//! * [`Outputs`] writes files completely or not at all.
//!
//! Errors name the file, the place in it, the value and what to do ([`FileError`]).

mod error;
mod machine;
mod mechanism;
mod outputs;
mod questions;
mod table;
mod urdf;

pub use error::FileError;
pub use machine::Machine;
pub use mechanism::document::{
    ActuatorSection, CableEntry, HomeSection, LegEntry, MechanismDocument, MountingSection, NoiseSection,
    PlatformSection, TargetEntry, ToleranceSection, WorkspaceSection,
};
pub use mechanism::entries::{EffectEntry, OffsetSection, SensorEntry};
pub use mechanism::plane::PlaneSection;
pub use outputs::Outputs;
pub use table::measurement_file::{Measurement, read_measurement};
pub use table::planned::{PlannedConditions, read_conditions};
pub use table::pose_file::{ListedPose, PoseList, read_parameter_errors, read_pose_list, read_poses};
pub use table::writer::{CsvTable, number};
pub use urdf::{Finding, FindingKind, HomeJoint, UrdfFiles, UrdfOptions, WrittenMechanism};
