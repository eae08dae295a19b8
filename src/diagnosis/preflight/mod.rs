//! Checks that the file is read as it was written. If another sign, unit or order fits much better, that is the answer:
//! no cause is looked for in a misread file.

pub(crate) mod assignment;
pub(crate) mod compare;
pub(crate) mod misreadings;
