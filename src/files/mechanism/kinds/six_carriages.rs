//! `type = "six-carriages"`: six rods of fixed length, each on a carriage of its own.

use super::closure_kind::{self, Drawing, PARTS};
use super::file_kind::FileKind;
use super::linear_delta::{put, rod};
use super::row::each;
use crate::files::error::FileError;
use crate::mechanism::closure::ClosureMechanism;
use crate::mechanism::kinds::{RodsOnRails, SixCarriages};

/// Six rods, each on a carriage of its own.
pub(super) const KIND: FileKind = FileKind {
    name: "six-carriages",
    label: "six rods, each on a carriage of its own",
    needed: &["length", "rail"],
    optional: &["stroke"],
    parts: PARTS,
    points_move: false,
    example: Some(include_str!("../examples/six-carriages.toml")),
    read: |source, warned| closure_kind::read::<RodsOnRails>(&KIND, draw, source, warned),
    write: |mechanism, target, document| closure_kind::write::<RodsOnRails>(mechanism, target, document, put),
};

fn draw(drawing: &Drawing<'_>) -> Result<ClosureMechanism<RodsOnRails>, FileError> {
    let Drawing { r, legs, home, tolerances, .. } = *drawing;
    let rods = each(r, legs, |at, l| rod(at, l, at.row - 1))?;
    SixCarriages::new(drawing.name, &rods, home, tolerances).map_err(|cause| r.geometry(cause))
}
