//! What a run is watched for: numbers that would be wrong, and assumptions that it leaves.

pub mod compatibility_window;
pub(crate) mod contradicting_drives;
pub mod energy_balance;
pub mod purpose;
pub mod validity;
