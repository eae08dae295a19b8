//! Tables in CSV: columns whose names carry the unit, cells, and what they mean (operating states, lists of poses); and the writer.

pub(crate) mod cells;
pub(crate) mod column;
pub(crate) mod joint_columns;
pub(crate) mod joint_table;
pub(crate) mod measurement_file;
pub(crate) mod planned;
pub(crate) mod pose_file;
pub(crate) mod states;
pub(crate) mod text_table;
pub(crate) mod time;
pub(crate) mod writer;
