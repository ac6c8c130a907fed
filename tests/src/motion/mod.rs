//! Motions measured against references, closed forms and conserved quantities.

pub mod deflection;
pub mod invariance;
pub mod order;
pub mod pictures;
pub mod published;
