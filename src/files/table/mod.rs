//! Tables in CSV: columns whose names carry the unit, cells, and what they mean (operating states, lists of poses); and the writer.

pub(crate) mod cells;
mod clock;
pub(crate) mod column;
pub(crate) mod joint_columns;
pub(crate) mod joint_table;
mod lacking;
pub(crate) mod measurement_file;
pub(crate) mod planned;
pub(crate) mod pose_file;
mod spelling;
pub(crate) mod states;
pub(crate) mod text_table;
mod time;
mod unused;
pub(crate) mod writer;
