//! The `reduce` program from outside: what it prints, how it exits, and what it leaves on the disk.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod assemble;
mod bad_components;
mod bad_descriptions;
mod bad_files;
mod batch;
mod cache;
mod calculix;
mod compare;
mod export;
mod extras;
mod fe_codes;
mod full_disk;
mod help;
mod import;
mod inspect;
mod interruption;
mod limits;
mod memory;
mod options;
mod output;
mod part_folder;
mod scene;
mod strangers;
mod study;
mod unit_systems;
mod update;
mod verify;
// Each program needs its part of it.
#[allow(dead_code)]
#[path = "../support/mod.rs"]
mod support;

/// The program.
const PROGRAM: &str = env!("CARGO_BIN_EXE_reduce");
