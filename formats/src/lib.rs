//! Data model and files of flexible-body superelements: components as FE codes export them, and the
//! `.dcb.h5` superelements made from them, the results of simulations, and the reports of studies.
//!
//! No numerics beyond checks, of shape, range and symmetry and of the identities that a superelement's numbers must keep: the reduction is in `dcb-reducer`, the dynamics in `dcb-runtime`,
//! and the two meet only through the types and files here.

pub mod component;
pub mod component_files;
pub mod dcb;
pub mod description;
pub mod error;
pub mod function;
pub mod further_column;
mod hdf5_files;
pub mod identities;
pub mod matrix;
pub mod mesh;
mod named;
pub mod out_of_memory;
pub mod output;
pub mod results;
pub mod scene;
pub mod snapshot;
pub mod stop_signal;
pub mod superelement;
pub mod terminal;
pub mod threads;
pub mod units;

pub use component::Component;
pub use description::{Description, component_schema, read_description};
pub use error::Error;
pub use function::{Function, TimeFunction};
pub use scene::Scene;
pub use superelement::{RecoveryBasis, Superelement};

/// Sparse matrix, compressed by columns, 32-bit indices: up to 2³¹ - 1 dofs and 2³² - 1 stored entries.
pub type SparseMatrix = faer::sparse::SparseColMat<u32, f64>;
