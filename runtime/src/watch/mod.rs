//! Watches of a run: for numbers that would be wrong, and assumptions that it leaves.

pub mod applicability;
pub mod compatibility_window;
pub(crate) mod contradicting_drives;
pub mod energy_balance;
pub mod validity;
