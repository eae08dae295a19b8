//! From columns to names: one effect is added, all are tried in each other's places, gross errors and the noise are judged
//! anew, until nothing changes.

pub(crate) mod agreement;
pub(crate) mod covariates;
pub(crate) mod curve;
pub(crate) mod iteration;
pub(crate) mod lags;
pub(crate) mod noise;
pub(crate) mod outliers;
pub(crate) mod pairs;
pub(crate) mod remainder;
pub(crate) mod reweighting;
pub(crate) mod stepwise;
pub(crate) mod structure;
pub(crate) mod unnamed;
mod whole_frame;
