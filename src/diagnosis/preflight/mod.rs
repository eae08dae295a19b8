//! Is the file read as it was written? Another sign, unit or order may fit much better, and is then the answer: no cause is
//! looked for in a file that was misread.

pub(crate) mod assignment;
pub(crate) mod compare;
pub(crate) mod misreadings;
