//! What a reduction costs, and what it may take.

pub mod basis_size;
pub mod forecast;
pub mod huge_pages;
pub mod machine_speed;
pub mod memory_limit;
pub(crate) mod stage;
