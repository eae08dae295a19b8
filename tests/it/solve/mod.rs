//! The solvers on the regression problems of NIST.

mod models;
mod nist_strd;
