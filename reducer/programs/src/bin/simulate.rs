//! `simulate`: scenes of superelements and rigid bodies, in motion.

use std::alloc::System;
use std::process::ExitCode;

use dcb_formats::out_of_memory::{EndsProgram, end_with};
use dcb_formats::output::remove_unfinished;

#[global_allocator]
static ALLOCATOR: EndsProgram<System> = EndsProgram(System);

fn main() -> ExitCode {
    end_with(
        "allow more, or ask for less: fewer nodes and channels that are recorded, \"modes\" of a superelement, fewer --threads",
        remove_unfinished,
    );
    ExitCode::from(dcb_programs::simulate::main(
        std::env::args_os(),
        dcb_programs::reduce::command,
    ))
}
