//! Scenes from their text to the motion: joints, drives, springs, loads, assembly and control, each against mechanics that
//! doesn't know the program's equations.

mod actuators;
mod assembly;
mod balance;
mod control;
#[path = "../../../runtime/examples/control_loop.rs"]
mod control_loop;
mod demands;
mod description;
mod drives;
mod efforts;
mod function;
mod joints;
mod laws;
mod loads;
#[path = "../../../runtime/examples/mechanism_in_rust.rs"]
mod mechanism_in_rust;
mod motion_laws;
pub mod parts;
mod point_masses;
mod silent_numbers;
mod springs;
mod wrenches;
