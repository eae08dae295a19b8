//! Planning: the detection limits of a campaign, and further measurements that tell two causes apart.

pub(crate) mod design;
pub(crate) mod scenarios;
pub(crate) mod settle;
