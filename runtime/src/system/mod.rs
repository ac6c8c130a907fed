//! Mechanisms of bodies.
pub mod body_factor;
pub mod joint_system;
pub mod marker;
