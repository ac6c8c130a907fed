//! Matrices as Abaqus and CalculiX write them.

pub mod coordinate;
pub mod matrix_input;
pub mod substructure;
