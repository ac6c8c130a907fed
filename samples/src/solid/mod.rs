//! Solid elements: shape functions, quadrature, assembly, and rectangular blocks made of them.

mod assemble;
mod block;
mod element;
pub(crate) mod lattice;
mod quadrature;
mod stress;

pub use assemble::{SolidMatrices, assemble_solid, jacobian_determinants};
pub(crate) use block::box_mesh;
pub use block::{box_block, reference_hexahedra, reference_tetrahedra, solid_component};
pub(crate) use element::HEXAHEDRON_EDGES;
pub use element::SolidElement;
pub use stress::nodal_stress;
