//! Other tools' files in: matrices, meshes and tables of dofs as other programs write them, told by their content.

pub mod binary_file;
pub mod cursor;
pub mod dof_table;
mod hashed_file;
pub mod line_blocks;
pub mod lines;
pub mod matrix;
pub mod mesh;
pub mod real;
pub mod row_key;
pub mod stored;
