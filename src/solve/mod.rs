//! Numerical solvers; they do not depend on mechanisms.
//!
//! Two problems occur in calibration, and each has one function that owns argmin's `Executor`:
//!
//! | problem | function | solver |
//! |---|---|---|
//! | six equations, six unknowns: forward kinematics (eqs. 4–11) | [`newton`] | `Newton`: LU, static sizes, damped |
//! | many equations: identification (eq. 27), registration | [`least_squares`] | Levenberg–Marquardt; Gauss–Newton by QR; argmin's own Gauss–Newton |
//!
//! **Why a function and not argmin's `run`:** `run` returns `Ok` when the iterations are used up, and when a
//! residual is not a number. Here everything but convergence is an error that carries the reason, the
//! iterations, the last step and the residual. argmin's types stay inside this module.
//!
//! **Which one.** Levenberg–Marquardt is the default everywhere. It begins with plain Gauss–Newton steps if
//! [`LeastSquaresOptions::initial_damping`] is 0, which suits a calibration that starts at the nominal
//! geometry, and damps as soon as a step fails. Gauss–Newton by QR is the paper's iteration. argmin's built-in
//! solver forms `(Jᵀ J)⁻¹`, which squares the condition of `J`; it stays as an independent check.
//!
//! References: Nocedal and Wright, *Numerical Optimization*, chapters 10 and 11; Moré 1978 (scaling by
//! column norms); Nielsen 1999 (the update of the damping).

mod decomposition;
mod gauss_newton;
mod inverse;
mod lanes;
mod least_squares;
mod levenberg_marquardt;
mod linear;
mod linearized;
mod minimum_norm;
mod newton;
mod pseudo_inverse;
mod small_cholesky;
mod state;
mod triangle;

pub(crate) use decomposition::{singular_values, svd, symmetric_eigen};
use gauss_newton::GaussNewton;
pub(crate) use inverse::inverse6;
pub(crate) use lanes::{LANES, Lanes, load, store, vectors};
pub use least_squares::{
    Convergence, EvaluationError, IterationRecord, LeastSquaresMethod, LeastSquaresOptions, LeastSquaresProblem,
    LeastSquaresSolution, SolveError, least_squares,
};
use levenberg_marquardt::LevenbergMarquardt;
pub use linear::LinearMethod;
pub(crate) use linearized::linearized;
pub(crate) use minimum_norm::{minimum_norm, minimum_norms};
pub use newton::{NewtonError, NewtonOptions, NewtonProblem, NewtonSolution, newton};
pub(crate) use pseudo_inverse::{pseudo_inverse, with_unit_columns};
pub(crate) use small_cholesky::SmallCholesky;
pub(crate) use triangle::{Triangle, exceeds, gram};
