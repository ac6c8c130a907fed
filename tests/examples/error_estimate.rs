//! Compares estimated errors of superelements with true ones, one JSON line each; with `--render`, turns such lines
//! (`docs/data/error_estimate.jsonl`) into the generated part of `docs/error-estimate.md`.

use dcb_tests::accuracy::sections;
use dcb_tests::{error_estimate, pages};

const COMMAND: &str = "cargo run --release -p dcb-tests --example error_estimate";

fn main() {
    if std::env::args().any(|argument| argument == "--render") {
        print!("{}", pages::error_estimate::PAGE.rendered());
        return;
    }
    println!("{}", sections::machine(COMMAND));
    for line in error_estimate::lines() {
        println!("{line}");
    }
}
