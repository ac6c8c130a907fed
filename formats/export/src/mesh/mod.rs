//! The mesh of a superelement: how its nodes move, and what a picture shows of it.

pub(crate) mod drawing;
pub(crate) mod node_shapes;
pub(crate) mod surface;
