//! Analyses about a state of the mechanism: equilibrium, vibrations, linearization.

mod assembled_damping;
mod effective_damping;
mod eigenmodes;
mod equilibrium;
mod frequency;
mod frequency_errors;
mod frequency_inputs;
mod frequency_paths;
mod inertia_relief;
mod linearization;
mod preload;
mod published_rotor;
mod whirl;
