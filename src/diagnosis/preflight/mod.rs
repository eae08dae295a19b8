//! Was the file read rightly? Asked before anything is fitted for good.

mod assignment;
mod attitude;
pub(crate) mod beside_effects;
pub(crate) mod compare;
mod found_frames;
mod in_base;
mod joint_columns;
mod mistakes;
mod reading;
mod regression;
mod table;
mod trial;
mod unit_factors;
mod zeros;
