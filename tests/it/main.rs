//! The integration tests, one program: rooms as in `src`, and the program as its users run it.
//!
//! One program is linked once and compiles what the tests share once. `cargo test --test it selection::` runs a room,
//! `cargo test --test it selection::gain` a file of it. Two programs stand apart: `allocations` counts what the
//! allocator of the whole process does, `browser` looks at pages in a browser.
#![allow(missing_docs, unreachable_pub, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

mod diagnosis;
mod effect;
mod files;
mod identification;
mod law;
mod measured;
mod measurement;
mod mechanism;
#[cfg(feature = "cli")]
mod program;
mod selection;
mod shared_data;
mod solve;
