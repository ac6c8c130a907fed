//! Binary files with matrices, as SciPy, MATLAB, h5py and PETSc write them: against the same matrices in Matrix Market files, and damaged.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod damage;
mod matlab5;
mod matlab73;
mod numpy;
mod petsc;
mod support;
