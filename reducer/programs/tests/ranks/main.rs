//! Factors on MPI processes: the same superelement as with a factor in this one, and what happens when MPI fails.
//!
//! `cargo test --release -p dcb-programs --features ranks`; needs MUMPS and Open MPI.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod agreement;
mod failures;
mod interruption;
#[allow(dead_code)]
#[path = "../reduce/part_folder.rs"]
mod part_folder;
mod processes;
#[allow(dead_code)]
#[path = "../support/mod.rs"]
mod support;

/// The program.
const PROGRAM: &str = env!("CARGO_BIN_EXE_reduce");

/// `mpirun` on a machine that has other things to do too, as root or not.
const MPIRUN: &str =
    "mpirun --allow-run-as-root --oversubscribe --bind-to none --mca mpi_yield_when_idle 1";
