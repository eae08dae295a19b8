//! The linear algebra of a diagnosis. At one point of the parameters everything is a column: parameters, effects, joints
//! ([`design_matrix`]), each row divided by its noise ([`spreads`]). The products of all columns over the rows that count
//! are summed once ([`kept_rows`]). A [`model`] is a fitted choice of these columns, a [`score_test`] says how much further
//! columns would gain, without a refit.

pub(crate) mod design_matrix;
pub(crate) mod hypotheses;
pub(crate) mod hypothesis;
pub(crate) mod kept_rows;
pub(crate) mod model;
pub(crate) mod normal_equations;
pub(crate) mod place_functions;
pub(crate) mod score_test;
pub(crate) mod spreads;
pub(crate) mod statistics;
pub(crate) mod unit_motion;
