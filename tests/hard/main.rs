//! Does the project stand where plain methods fall?
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod dynamics;
mod identity_defects;
mod mechanism_properties;
mod random_chain;
mod reduction;
mod reduction_properties;
