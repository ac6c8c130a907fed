//! `reduce`: finite-element matrices to a superelement.

use std::process::ExitCode;

fn main() -> ExitCode {
    dcb_reducer::cli::main()
}
