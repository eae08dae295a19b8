//! Mechanisms from one function: the closure residual `g(q, h, C)`.
//!
//! If you can write down how the loops of a machine close, you have a [`Mechanism`](super::Mechanism). [`Closure`] asks
//! for that one function, written once for any scalar; [`ClosureMechanism`] evaluates it with dual numbers and gets
//!
//! | from | by |
//! |---|---|
//! | `J₁`, `J₂`, `∂g/∂h` to machine precision | forward-mode dual numbers in lanes of eight |
//! | forward kinematics | Newton on `g` (six rows), least squares on `g` (more) |
//! | inverse kinematics | least squares in the joints, from home and along the branch of home |
//! | `J_b` | `-J₁⁺ J₂` |
//!
//! ```
//! use paracal::mechanism::closure::{Closure, Real, State};
//!
//! /// Three telescopic legs in the plane z = 0.
//! #[derive(Clone, Debug)]
//! struct Planar;
//!
//! impl Closure for Planar {
//!     fn residual<T: Real>(&self, s: &State<'_, T>, out: &mut [T]) {
//!         for leg in 0..3 {
//!             let c = &s.parameters[4 * leg..4 * leg + 4];
//!             let zero = T::from(0.0);
//!             let tip = s.place(&[c[0], c[1], zero].into());
//!             out[leg] = (tip - nalgebra::Vector3::new(c[2], c[3], zero)).dot(&(tip - nalgebra::Vector3::new(c[2], c[3], zero))).sqrt() - s.joints[leg];
//!         }
//!         // Structural rows: the platform stays in the plane.
//!         out[3] = s.position.z;
//!         out[4] = s.rotation[(0, 2)];
//!         out[5] = s.rotation[(1, 2)];
//!     }
//! }
//! ```
//!
//! **Lower mobility.** A machine with fewer joints than six states its structural constraints as further rows and says
//! in [`Outline::controlled`] which coordinates of the pose its joints control. The others follow from the closure.
//!
//! **Passive coordinates** `z` (the tilt of an offset joint, the coupler of a linkage) may appear in the residual.
//! They are solved for and eliminated: with `Q` from the QR decomposition of `∂g/∂z`, the rows `Q⊥ᵀ g` do not depend
//! on them to first order, and they are the closure equations that the rest of the library sees.
//!
//! **Sparsity.** A row rarely depends on the parameters of another leg. [`Closure::depends`] may say so; columns that
//! share no row then travel in one lane (Curtis, Powell and Reid 1974), which makes the derivatives of a closure of six
//! legs about as cheap as those of one leg. What it says is checked when the mechanism is made.

mod check;
mod evaluation;
mod inverse;
mod lanes;
mod made;
mod outline;
mod passive;
mod pattern;

use std::fmt::Debug;

use nalgebra::{Matrix3, Vector3};
use num_dual::DualNum;

pub use made::ClosureMechanism;
pub use outline::Outline;

use crate::conditions::Conditions;

/// A scalar that a closure computes with: `f64`, or a dual number that carries derivatives.
///
/// Arithmetic with `f64` on the right, `T::from(1.0)`, `sqrt`, `sin_cos` and their kin are at hand; what the closure
/// does may depend on `re()`, the value.
pub trait Real: DualNum<f64> + Copy {}

impl<T: DualNum<f64> + Copy> Real for T {}

/// Where a closure is evaluated, SI.
#[derive(Debug)]
pub struct State<'a, T: Real> {
    /// Position of the platform's origin in the base frame.
    pub position: Vector3<T>,
    /// Rotation from the platform frame to the base frame.
    pub rotation: Matrix3<T>,
    /// Joint coordinates `h`.
    pub joints: &'a [T],
    /// Parameters `C`, in the order of the [`Outline`].
    pub parameters: &'a [T],
    /// Passive coordinates `z`.
    pub passive: &'a [T],
    /// Operating state.
    pub conditions: &'a Conditions,
}

impl<T: Real> State<'_, T> {
    /// Where the platform point `a` stands in the base frame.
    #[inline(always)]
    pub fn place(&self, a: &Vector3<T>) -> Vector3<T> {
        let (r, t) = (&self.rotation, &self.position);
        Vector3::new(
            r[(0, 0)] * a.x + r[(0, 1)] * a.y + r[(0, 2)] * a.z + t.x,
            r[(1, 0)] * a.x + r[(1, 1)] * a.y + r[(1, 2)] * a.z + t.y,
            r[(2, 0)] * a.x + r[(2, 1)] * a.y + r[(2, 2)] * a.z + t.z,
        )
    }

    /// A direction turned by the two parameters from `first` on, rad. Small turns leave its length one in first order;
    /// divide by [`length`] where more is needed.
    #[inline(always)]
    pub fn turned(&self, direction: &Direction, first: usize) -> Vector3<T> {
        let (m, n) = (self.parameters[first], self.parameters[first + 1]);
        let [across, other] = &direction.across;
        Vector3::from_fn(|k, _| m * across[k] + n * other[k] + direction.along[k])
    }

    /// The three parameters from `first` on as a point.
    #[inline(always)]
    pub fn point(&self, first: usize) -> Vector3<T> {
        Vector3::new(self.parameters[first], self.parameters[first + 1], self.parameters[first + 2])
    }
}

/// A direction that parameters may turn: the axis of a crank or of a hinge, a rail.
#[derive(Clone, Debug, PartialEq)]
pub struct Direction {
    /// The direction as it was drawn, of length one.
    pub along: Vector3<f64>,
    /// Two directions across it, towards which the parameters turn it. They depend on nothing but `along`, so that the
    /// values of a file mean the same turn wherever they are read.
    pub across: [Vector3<f64>; 2],
}

impl Direction {
    /// The direction of a vector of any length; `None` if it has none.
    pub fn of(vector: &Vector3<f64>) -> Option<Self> {
        let along = vector.try_normalize(0.0).filter(|v| v.iter().all(|x| x.is_finite()))?;
        let least = along.iamin();
        let across = along.cross(&Vector3::ith(least, 1.0)).normalize();
        Some(Self { along, across: [across.cross(&along), across] })
    }
}

/// The length of a vector.
#[inline(always)]
pub fn length<T: Real>(v: &Vector3<T>) -> T {
    (v.x * v.x + v.y * v.y + v.z * v.z).sqrt()
}

/// The scalar product with a constant vector.
#[inline(always)]
pub fn along<T: Real>(v: &Vector3<T>, constant: &Vector3<f64>) -> T {
    v.x * constant.x + v.y * constant.y + v.z * constant.z
}

/// A quantity that a row of the closure may depend on, in addition to the pose and the passive coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// A parameter, by its place in the [`Outline`].
    Parameter(usize),
    /// A joint.
    Joint(usize),
}

/// The closure equations of a mechanism.
pub trait Closure: Clone + Debug + Send + Sync + 'static {
    /// `g(q, h, C)`: writes one number for each closure equation; all are zero when the loops close.
    ///
    /// Rows should be lengths (m), so that a residual means the same in each. `out` has
    /// [`Outline::equations`] entries.
    fn residual<T: Real>(&self, state: &State<'_, T>, out: &mut [T]);

    /// Whether a row may depend on a column. Everything may, unless this says otherwise.
    fn depends(&self, _row: usize, _on: Column) -> bool {
        true
    }
}
