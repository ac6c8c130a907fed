//! Other tools' files in: matrices, meshes and tables of dofs as other programs write them, told by their content.

pub mod dof_table;
pub mod matrix;
pub mod mesh;
pub mod stored;

mod binary;
mod draft_description;
mod import;
mod interfaces;
mod operators;
mod part;
mod proof;
mod report;
mod request;
mod rigid_motions;
mod rows;
mod source;
mod text;

pub use draft_description::described;
pub use import::{Imported, import};
pub use interfaces::RequestedSet;
pub use report::{ImportReport, MassCentre};
pub use request::{Import, LostOrder, NodeOrder, RowSource, units};
pub use source::matrices::mass_beside;
pub use source::matrix_file::{MatrixFile, is_matrix_market};
pub use source::named_file::NamedFile;
pub use source::part_mesh::{MeshBeside, is_json, mesh_beside};
