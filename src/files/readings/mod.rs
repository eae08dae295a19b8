//! Kinds of reading: what may be measured of a sample, one kind in each file, and the table of all of them.
//!
//! A new kind is its [`MeasurementModel`](crate::measurement::MeasurementModel), a file beside these that implements
//! [`ReadingKind`], and a line in [`KINDS`].

pub(crate) mod contact;
pub(crate) mod kind;
pub(crate) mod pose;
pub(crate) mod targets;

use crate::files::machine::Machine;
use crate::files::readings::contact::ContactKind;
use crate::files::readings::kind::ReadingKind;
use crate::files::readings::pose::PoseKind;
use crate::files::readings::targets::TargetsKind;
use crate::files::table::column::ReadingColumn;
use crate::units::Dimension;

/// All kinds. A file holds one of them.
pub(crate) const KINDS: [&dyn ReadingKind; 3] = [&PoseKind, &TargetsKind, &ContactKind];

/// What names of columns mean to the kinds. Columns may be called by what the file of `machine` names, if it is given.
pub(crate) fn reading_columns(machine: Option<&Machine>) -> impl Fn(&str) -> Option<(ReadingColumn, Dimension)> + '_ {
    move |name| KINDS.iter().find_map(|kind| kind.column(name, machine))
}

/// The kind of this name.
#[cfg(feature = "cli")]
pub(crate) fn reading_kind(name: &str) -> Option<&'static dyn ReadingKind> {
    KINDS.into_iter().find(|kind| kind.name() == name)
}
