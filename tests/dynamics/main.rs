//! Do bodies, mechanisms and scenes move as mechanics says, and is the rest refused by name?
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod analyses;
mod body;
mod compatibility;
mod linear;
mod outputs;
mod scenes;
mod steps;
mod support;
