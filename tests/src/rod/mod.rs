//! Flexible rods of slider-cranks: reduced, and corotated as an oracle; their deflections.

pub mod corotated;
pub mod deflection;
pub mod reduced;
