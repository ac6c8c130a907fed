//! Analyses about a state of the mechanism: equilibrium, vibrations, linearization.

mod effective_damping;
mod eigenmodes;
mod equilibrium;
mod frequency;
mod linearization;
