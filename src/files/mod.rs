//! Files: mechanism files (TOML, URDF), measurements and pose lists (CSV), and how output reaches the disk.
//!
//! * [`Machine`] is a mechanism file: the mechanism, and what else is known about it (workspace, noise,
//!   targets). Units are named in the file; everything is SI once it is read.
//! * [`read_measurement`], [`read_poses`] and [`read_conditions`] read CSV whose column names carry the unit.
//! * [`Outputs`] writes files completely or not at all.
//!
//! Errors name the file, the place in it, the value and what to do ([`FileError`]).

mod base_frame;
mod error;
mod finding;
mod format;
mod machine;
mod mechanism;
mod open;
mod outputs;
mod own;
mod questions;
mod read_options;
mod readings;
mod table;
#[cfg(feature = "urdf")]
mod urdf;
mod urdf_options;

pub use error::{FileError, contents};
pub use finding::{Finding, FindingKind};
pub use machine::Machine;
pub use mechanism::calibration::CalibrationSection;
pub use mechanism::document::MechanismDocument;
pub use mechanism::examples::{ExampleFile, example_files};
pub use mechanism::sections::{
    ActuatorSection, CableEntry, EffectEntry, GravityAxis, HomeSection, LegEntry, MountingSection, NoiseSection,
    OffsetSection, ParameterEntry, PlaneSection, PlatformSection, SensorEntry, TargetEntry, ToleranceSection,
    WorkspaceSection,
};
pub use outputs::Outputs;
pub use read_options::ReadOptions;
#[cfg(feature = "cli")]
pub(crate) use readings::{KINDS as READING_KINDS, reading_kind};
pub use table::joint_table::{JointsAndPose, joints_and_poses, labelled_joints};
pub use table::measurement_file::{Measurement, read_measurement};
pub use table::planned::{PlannedConditions, read_conditions};
pub use table::pose_file::{ListedPose, PoseList, read_parameter_errors, read_pose_list, read_poses};
pub use table::writer::{CsvTable, number};
#[cfg(feature = "urdf")]
pub use urdf::{output::WrittenMechanism, writer::UrdfFiles};
pub use urdf_options::{HomeJoint, UrdfOptions};
