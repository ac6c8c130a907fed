//! How binary files store matrices: numbers one after the other, in full, or line by line with the places across.

pub(crate) mod collected;
pub(crate) mod compressed;
pub(crate) mod dense;
pub(crate) mod number;
pub(crate) mod stream;
