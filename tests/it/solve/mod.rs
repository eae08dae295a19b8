//! The solvers on the regression problems of NIST.

mod nist_strd;
