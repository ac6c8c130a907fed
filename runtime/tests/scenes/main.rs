//! Scenes from their text to the motion: joints, drives, springs, loads, assembly and control, each against mechanics that
//! doesn't know the program's equations.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod assembly;
mod balance;
mod control;
#[path = "../../examples/control_loop.rs"]
mod control_loop;
mod demands;
mod drives;
mod joints;
mod loads;
#[path = "../../examples/mechanism_in_rust.rs"]
mod mechanism_in_rust;
mod parts;
mod springs;
mod wrenches;
