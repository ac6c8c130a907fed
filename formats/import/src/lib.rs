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

mod choice;
mod displacement_axes;
mod doubt;
mod draft_description;
mod import;
mod interfaces;
mod lost_order;
mod lost_positions;
mod matrix_file;
mod named_file;
mod node_order;
mod null_space;
mod operators;
mod part;
mod part_mesh;
mod partner;
mod proof;
mod report;
mod request;
mod rigid_motions;
mod rotation_node;
mod row_labels;
mod row_order;
mod source_files;

pub use draft_description::described;
pub use import::{Imported, import};
pub use interfaces::RequestedSet;
pub use matrix_file::{MatrixFile, is_matrix_market};
pub use named_file::NamedFile;
pub use part_mesh::{is_component_file, mesh_beside};
pub use report::{ImportReport, MassCentre};
pub use request::{Import, LostOrder, RowSource, units};
pub use row_order::NodeOrder;
pub use source_files::mass_beside;
