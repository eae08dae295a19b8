//! URDF files of mechanisms with six legs of variable length.
//!
//! URDF describes a tree of links and joints; a parallel mechanism has loops. Each tool states the missing closures in
//! its own way, so a file goes through these steps:
//!
//! 1. [`xml`] reads the text within bounds, [`description`] keeps what matters and checks every number, and
//!    `urdf-rs` reads the reduced rest: its joints and links are those of [`model`].
//! 2. [`closures`] collects the tags that close loops, [`pairs`] the closing frames and the pairs of [`side`] files
//!    and of the call; [`agree`] sorts out what is stated twice.
//! 3. [`graph`] finds base, platform and legs by their connections, [`leg`] and [`anchor`] the anchors `a`, `b` and the length
//!    `L0` at joint coordinate zero: with `c` the common point of the axes at the platform's end,
//!    `L0 = |c - b|` and `length = L0 ± q`. Names decide only which
//!    link carries the frame of its body. The zero pose need not be assembled, but for closures that state their place in
//!    one link only (`<gazebo><joint>`).
//! 4. [`extract`] puts it together, with the pose at [`home`]: that of the tree if it closes every loop, else the nearest
//!    that fits the lengths.
//!
//! The result is the same document that a TOML file holds, so all else is common to both. Everything that is wrong
//! is collected as [findings](super::finding). [`writer`] goes the other way.

mod agree;
mod anchor;
mod attributes;
mod beside;
mod bodies;
mod choice;
mod closures;
mod description;
mod extract;
mod findings;
mod found;
mod graph;
mod home;
mod lacks;
mod leg;
mod model;
pub(super) mod output;
mod pairs;
pub(super) mod read;
mod settings;
pub(super) mod side;
pub(super) mod writer;
mod xml;
