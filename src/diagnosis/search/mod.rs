//! TODO

pub(crate) mod covariates;
pub(crate) mod iteration;
pub(crate) mod noise;
pub(crate) mod outliers;
pub(crate) mod remainder;
pub(crate) mod stepwise;
