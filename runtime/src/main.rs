//! `simulate`: scenes of superelements and rigid bodies, in motion.

use std::process::ExitCode;

fn main() -> ExitCode {
    dcb_runtime::cli::main()
}
