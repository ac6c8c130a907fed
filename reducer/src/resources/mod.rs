//! Cost of a reduction, and its limits.

pub mod basis_size;
pub mod forecast;
pub mod huge_pages;
pub mod machine_speed;
pub mod memory_limit;
pub(crate) mod stage;
