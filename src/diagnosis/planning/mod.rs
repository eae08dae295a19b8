//! Before a campaign and between two: what planned poses could show, and which further measurements tell two causes apart.

pub(crate) mod design;
pub(crate) mod scenarios;
pub(crate) mod settle;
