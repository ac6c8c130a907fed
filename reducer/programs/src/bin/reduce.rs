//! `reduce`: finite-element matrices to a superelement.

use std::process::ExitCode;

use dcb_formats::out_of_memory::{EndsProgram, end_with};
use dcb_formats::output::remove_unfinished;
use dcb_reducer::resources::huge_pages::{HugePages, keep_freed_memory};

#[global_allocator]
static ALLOCATOR: EndsProgram<HugePages> = EndsProgram(HugePages);

fn main() -> ExitCode {
    keep_freed_memory();
    end_with(
        "allow more, or ask for less: fewer --threads or --modes, --factor disk; see reduce plan",
        remove_unfinished,
    );
    ExitCode::from(dcb_programs::reduce::main(
        std::env::args_os(),
        dcb_programs::simulate::command,
    ))
}
