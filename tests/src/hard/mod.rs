//! Hard cases: each runs a plain method, which fails, beside this project's.

pub mod case;
pub mod dynamics;
pub mod reduction;
