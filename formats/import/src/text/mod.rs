//! Text files: lines, one after the other or in blocks by all threads, and the numbers in them.

pub(crate) mod cursor;
pub(crate) mod line_blocks;
pub(crate) mod lines;
pub(crate) mod real;
