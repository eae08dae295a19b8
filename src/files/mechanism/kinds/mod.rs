//! The kinds of mechanism that a file may state.
//!
//! | `type` | `[[leg]]` needs | may have |
//! |---|---|---|
//! | `six-hardpoint` | `platform base length` | `length_offset stroke`, and the nominal points in a calibrated file |
//! | `rotary-stewart` | `platform base length crank axis zero` | `angle_offset stroke` |
//! | `rotary-delta` | `platform base length crank axis zero motor` | `angle_offset stroke` |
//! | `linear-delta` | `platform base length carriage rail` | `stroke` |
//! | the same, with `[delta]` | has no legs | |
//! | `six-carriages` | `platform base length rail` | `stroke` |
//! | `tripod-3rps` | `platform base axis` | `length_offset hinge_tilt stroke` |
//! | `cables` | `platform base`, and `[[cable]] segments` | `pulley swivel` of a segment, `drum build_up length_offset stroke` of a cable |
//! | `planar-cables` | `platform base`, and `[[cable]] segments` | `drum length_offset stroke` of a cable |
//! | `pose` | has no legs | `[offset]` |
//! | `own` | has no legs | `[[parameter]]`, in a calibrated file |
//!
//! Each is one [`FileKind`] in a file of its own, and [`KINDS`] lists them; nothing else knows which kinds there are.

mod cables;
mod closure_kind;
pub(crate) mod file_kind;
mod linear_delta;
pub(crate) mod own;
mod planar_cables;
pub(crate) mod pose;
mod rotary_delta;
mod rotary_stewart;
mod row;
mod six_carriages;
pub(crate) mod six_hardpoint;
mod tripod;

use file_kind::FileKind;

/// Every kind, in the order in which errors list them.
pub(crate) const KINDS: [&FileKind; 10] = [
    &six_hardpoint::KIND,
    &rotary_stewart::KIND,
    &rotary_delta::KIND,
    &linear_delta::KIND,
    &six_carriages::KIND,
    &tripod::KIND,
    &cables::KIND,
    &planar_cables::KIND,
    &pose::KIND,
    &own::KIND,
];

/// The kind of this name.
pub(crate) fn kind(name: &str) -> Option<&'static FileKind> {
    KINDS.into_iter().find(|kind| kind.name == name)
}
