//! Blind cases: measurement files in which something is hidden, and the truth about them.
//!
//! A diagnosis that is tested on data made by its own equations proves algebra only. Nothing in these modules calls the
//! library: they have their own forward kinematics, their own effects, their own draws. Joints, anchors, lengths and
//! measured poses are moved at the true state of the machine, and what comes out is the text of two files, as a user
//! would bring them, with the truth beside them.
//!
//! [`cases::draw`] is the door. Case `k` of a kind and a seed is always the same case, whatever was drawn before.
#![allow(dead_code, missing_docs, unreachable_pub)]

pub mod cases;
pub mod effects;
pub mod hexapod;
pub mod limits;
pub mod mistakes;
pub mod others;
pub mod run;
pub mod setting;
pub mod stage;
pub mod text;
pub mod unlisted_effects;
