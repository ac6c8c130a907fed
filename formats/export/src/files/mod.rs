//! Files that are made, written whole or not at all.

pub(crate) mod arrays;
pub(crate) mod hdf5_tree;
pub(crate) mod mat5;
pub(crate) mod op4;
pub(crate) mod product;
