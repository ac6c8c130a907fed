//! How the nodes of a superelement move.

pub(crate) mod node_shapes;
