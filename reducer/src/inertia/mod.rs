//! Inertia invariants, and what spin, loads and interface forces do inside the part.

pub mod invariants;
pub(crate) mod part_loads;
pub mod spin_forces;
pub(crate) mod stiffening;
