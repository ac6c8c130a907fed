//! `reduce`: finite-element matrices to a superelement.

use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: dcb_reducer::huge_pages::HugePages = dcb_reducer::huge_pages::HugePages;

fn main() -> ExitCode {
    dcb_reducer::huge_pages::keep_freed_memory();
    dcb_reducer::cli::main()
}
