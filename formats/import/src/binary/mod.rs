//! Binary files, in order or in parts, with the digest of the whole.

pub(crate) mod file;
pub(crate) mod hashed;
