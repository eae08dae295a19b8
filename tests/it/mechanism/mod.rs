//! Kinematics: closures against closed forms, published machines, mechanisms from outside the crate.

#[cfg(feature = "conformance")]
mod closures;
mod forward_batch;
mod forward_kinematics;
#[cfg(feature = "conformance")]
mod kinds;
#[cfg(all(feature = "cli", feature = "conformance"))]
mod mounted;
mod own_machine;
#[cfg(feature = "conformance")]
mod own_mechanism;
#[cfg(feature = "conformance")]
mod passive;
#[cfg(feature = "conformance")]
mod pose_positioner;
mod published_hexapods;
