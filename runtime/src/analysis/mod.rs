//! Analyses beside motion over time: rest, motion that drives fix, small vibrations.

pub mod assembled_damping;
pub mod driven;
pub mod effective_damping;
pub mod eigenmodes;
pub mod equilibrium;
pub mod independent;
pub mod inertia_relief;
pub mod variation;
