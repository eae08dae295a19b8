//! Kinds of mechanism that are made from one closure function each.
//!
//! | kind | rows of the closure | joints | parameters of a leg |
//! |---|---|---|---|
//! | [`RotaryStewart`] (6-RSS) | `\|t + R aᵢ - bᵢ - rᵢ (cos φᵢ uᵢ + sin φᵢ vᵢ)\| - sᵢ`, `φᵢ = hᵢ + oᵢ` | six crank angles | `a b s r o` |
//! | [`RotaryDelta`] | the same for six rods, two to a crank | three crank angles | `a b s` of a rod, `r o` of a crank |
//! | [`LinearDelta`] | `\|t + R aᵢ - bᵢ - h_k d_k\| - sᵢ` for six rods, two to a carriage `k` | three carriages | `a b s` |
//! | [`TiedDelta`] | `\|t - (ρ_k cos θ_k, ρ_k sin θ_k, h_k + e_k)\| - s_k`, and no turns | three carriages | endstop, radius, angle, arm |
//! | [`SixCarriages`] (6-PUS) | as the linear delta with a carriage to each rod | six carriages | `a b s` |
//! | [`Tripod`] (3-RPS) | `\|lᵢ\| - (hᵢ + oᵢ)` and `nᵢ · lᵢ`, `lᵢ = t + R aᵢ - bᵢ` | three lengths | `a b o` and the tilt `m n` of the hinge |
//! | [`Cables`] | `Σ_k w_jk (l_k - l_k₀) - (ρ_j h_j + ½ κ_j h_j² + o_j)` | cables, or angles of their drums | `a b` of a segment, `o ρ κ` of a cable |
//! | [`PlanarCables`] | `Σ_k w_jk (\|l_k\| - \|l_k\|₀) - (ρ_j h_j + o_j)` and the plane | cables, or angles of their drums | `a b` of a segment, `o ρ` of a cable |
//!
//! The rods of a delta are six, and its pose is that of a free body: rods that are not quite parallel tilt the platform,
//! which a model with three rods cannot say; [`TiedDelta`] is that model, with the numbers that firmware has. Where joints control
//! fewer than six coordinates, structural rows keep the others. Directions (`u`, `v`, `d`, the nominal `n`) are constants of the drawing.
//!
//! Every kind has a `new` that takes typed legs in SI and gives a [`ClosureMechanism`].

mod cables;
mod planar_cables;
mod rods_on_cranks;
mod rods_on_rails;
mod tied_delta;
mod tripod;

pub use cables::{Cables, Pulley};
pub use planar_cables::{Cable, PlanarCables, Segment};
pub use rods_on_cranks::{CrankLeg, RodsOnCranks, RotaryDelta, RotaryStewart};
pub use rods_on_rails::{LinearDelta, Rod, RodsOnRails, SixCarriages};
pub use tied_delta::{PerTower, TiedDelta, Towers};
pub use tripod::{HingedLeg, Tripod};

use nalgebra::Vector3;

use super::GeometryError;

#[allow(unused_imports)] // named in the page above
use super::closure::ClosureMechanism;
use super::closure::Direction;

/// 1σ of manufacture of the parameters of a kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Of a coordinate of an anchor, m.
    pub anchor: f64,
    /// Of a length: rods, cranks, drums, offsets of linear joints, m.
    pub length: f64,
    /// Of an angle: offsets of cranks, tilts of hinges, rad.
    pub angle: f64,
}

/// The direction of a vector of any length.
fn direction(leg: usize, what: &str, v: &Vector3<f64>) -> Result<Direction, GeometryError> {
    let none =
        || GeometryError::Outline(format!("leg {}: `{what}` [{}, {}, {}] is not a direction", leg + 1, v.x, v.y, v.z));
    Some(v).filter(|v| v.norm() > 1e-12).and_then(Direction::of).ok_or_else(none)
}

/// A direction of length one.
fn unit(leg: usize, what: &str, v: &Vector3<f64>) -> Result<Vector3<f64>, GeometryError> {
    Ok(direction(leg, what, v)?.along)
}

/// Refuses anything but a positive length.
fn positive(leg: usize, what: &str, value: f64) -> Result<(), GeometryError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(GeometryError::Outline(format!("leg {}: `{what}` must be positive, found {value}", leg + 1)))
}

/// `1 rod`, `3 rods`.
fn rods_in_words(count: usize) -> String {
    format!("{count} {}", if count == 1 { "rod" } else { "rods" })
}

/// Refuses a wrong number of legs.
fn count(kind: &str, what: &str, expected: usize, found: usize) -> Result<(), GeometryError> {
    if expected == found {
        return Ok(());
    }
    Err(GeometryError::Outline(format!("a {kind} has {expected} {what}, found {found}")))
}
