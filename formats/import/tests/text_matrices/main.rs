//! Text matrices of Abaqus, CalculiX and Ansys: each against the same matrix in Matrix Market, another program's reading, or a computation.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod coordinate;
#[allow(dead_code)]
#[path = "../binary_matrices/damage.rs"]
mod damage;
mod dof_table;
mod harwell_boeing;
mod matrix_input;
mod recognition;
mod substructure;
#[allow(dead_code)]
#[path = "../binary_matrices/support.rs"]
mod support;
mod text;
