//! The files of a part: which are there, what they are, and which of their matrices and meshes are taken.

mod choice;
mod closed_formats;
pub(crate) mod matrices;
pub(crate) mod matrix_file;
pub(crate) mod named_file;
pub(crate) mod part_mesh;
pub(crate) mod partner;
