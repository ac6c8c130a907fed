//! Data model and files: components as finite-element codes export them, the `.dcb.h5` superelements made from them, scenes, and the results
//! of simulations.
//!
//! Files from anybody are checked before they are believed: shapes, ranges, symmetry, and the identities that a superelement's numbers must
//! keep. Other numerics are elsewhere: `dcb-superelement` has what follows from one superelement, `dcb-reducer` the reduction, `dcb-runtime`
//! the dynamics.
//!
//! ```
//! use dcb_formats::dcb::{Contents, SuperelementFile, WriteOptions, write_superelement};
//!
//! let file = SuperelementFile::open("../samples/slider-crank/rod.dcb.h5")?;
//! let rod = file.superelement()?;
//! assert_eq!(rod.interfaces.len(), 2);
//!
//! // For a customer: nothing of the inside of the component.
//! let folder = tempfile::tempdir()?;
//! let target = folder.path().join("rod.dcb.h5");
//! let contents = Contents { superelement: &rod, recovery: None, mesh: None };
//! write_superelement(&target, &contents, &WriteOptions::default())?;
//! assert!(SuperelementFile::open(&target)?.recovery()?.is_none());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod assembly;
pub mod component;
pub mod component_files;
pub mod dcb;
pub mod description;
pub mod error;
pub mod function;
pub mod linear_system;
pub mod matrix;
pub mod measured;
pub mod mesh;
pub mod results;
pub mod scene;
pub mod superelement;
pub mod units;
pub mod vtk;

// No part of the door: for the other crates of this workspace and its tests.
#[doc(hidden)]
pub mod further_column;
#[doc(hidden)]
pub mod hdf5_files;
#[doc(hidden)]
pub mod identities;
#[doc(hidden)]
pub mod out_of_memory;
#[doc(hidden)]
pub mod output;
#[doc(hidden)]
pub mod snapshot;
#[doc(hidden)]
pub mod terminal;
#[doc(hidden)]
pub mod threads;

mod json_text;
mod named;

pub use component::Component;
pub use description::{Description, component_schema, read_description};
pub use error::Error;
pub use function::{Function, TimeFunction};
pub use scene::Scene;
pub use superelement::{RecoveryBasis, Superelement};

#[doc(hidden)]
pub use hdf5_files::write_hdf5;

/// Sparse matrix, compressed by columns, 32-bit indices: up to 2³¹ - 1 dofs and 2³² - 1 stored entries.
pub type SparseMatrix = faer::sparse::SparseColMat<u32, f64>;
