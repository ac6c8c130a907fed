//! Sparse symmetric matrices: fill-reducing order, multifrontal factorization, solutions that are refined where the factor is in single
//! precision, products with tall blocks, and a Krylov basis of these. With the feature
//! `ranks` a factor may be spread over processes on many machines.
//!
//! Every sum has a fixed order, so results are the same to the last bit whatever the number of threads.
//!
//! ```
//! use dcb_formats::SparseMatrix;
//! use dcb_sparse::factorization::SymmetricFactor;
//! use faer::sparse::Triplet;
//! use faer::mat;
//!
//! // Two masses between springs: (K + σ M) x = f.
//! let matrix = |entries: [[f64; 2]; 2]| {
//!     let all = (0..4_u32).map(|at| Triplet::new(at / 2, at % 2, entries[at as usize / 2][at as usize % 2]));
//!     SparseMatrix::try_new_from_triplets(2, 2, &all.collect::<Vec<_>>())
//! };
//! let (stiffness, mass) = (matrix([[2.0, -1.0], [-1.0, 2.0]])?, matrix([[1.0, 0.0], [0.0, 1.0]])?);
//! let mut factor = SymmetricFactor::analyse(&stiffness, &mass, &[0, 1])?;
//! let shifted = factor.factorize(&stiffness, &mass, 1.0).map_err(|why| format!("{why:?}"))?;
//! let mut x = mat![[8.0], [0.0]];
//! shifted.solve_in_place(x.as_mut())?;
//! assert!((x[(0, 0)] - 3.0).abs() < 1e-14 && (x[(1, 0)] - 1.0).abs() < 1e-14);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod factor_store;
pub mod factorization;
mod inertia;
mod ordering;
mod positive_factor;
mod prefetch;
#[cfg(feature = "ranks")]
pub mod ranks;
mod refinement;
mod sparse_product;
mod tall_products;
mod unfactorized;
mod zeros;

// No part of the door: for the other crates of this workspace and its tests.
#[doc(hidden)]
pub mod block_algebra;
#[doc(hidden)]
pub mod column_products;
#[doc(hidden)]
pub mod krylov_basis;
#[doc(hidden)]
pub mod multifrontal;

mod error;

pub use error::Error;
