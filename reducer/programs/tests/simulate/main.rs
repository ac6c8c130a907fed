//! The `simulate` program from outside: what it prints, how it exits, and what it leaves on the disk.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod campbell;
mod commands;
mod constraints;
mod first_steps;
mod fmu;
mod gallery;
mod internal_rows;
mod limits;
mod linear_analyses;
mod linearize;
mod messages;
mod motion_in_plane;
mod needed;
mod notes;
mod options;
mod output;
mod page;
mod pages_run;
mod planar_scenes;
mod prepare_stopped;
mod prepared_fields;
mod printed;
mod records;
mod runs;
mod scene_folder;
mod scenes;
mod scope;
mod strangers;
mod study;
mod study_accuracy;
mod superelements;
mod tutorial;
// Each program needs its part of it.
#[allow(dead_code)]
#[path = "../support/mod.rs"]
mod support;

/// The program.
const PROGRAM: &str = env!("CARGO_BIN_EXE_simulate");
