//! Meshes of other tools: each against the same part in another format, another library's reading, or what the geometry says.

#![allow(clippy::unwrap_used, clippy::panic)]

mod abaqus;
mod bracket;
mod cell_shapes;
mod damage;
mod gmsh;
mod nastran;
mod samples;
mod universal;
mod vtu;
