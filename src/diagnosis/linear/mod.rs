//! TODO

pub(crate) mod design_matrix;
pub(crate) mod hypotheses;
pub(crate) mod joint_functions;
pub(crate) mod model;
pub(crate) mod score_test;
pub(crate) mod statistics;
