//! Rows of the matrices: which motion of which node each is, and in what order they come.

pub(crate) mod displacement_axes;
pub(crate) mod labels;
pub(crate) mod lost_order;
pub(crate) mod lost_positions;
pub(crate) mod order;
