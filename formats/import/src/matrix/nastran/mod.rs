//! Matrices as Nastran writes them.

pub mod dmig;
pub mod op4;
