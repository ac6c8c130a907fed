//! Compares estimated errors of superelements with true ones, one JSON line each; with `--render`, turns such lines
//! (`docs/data/error_estimate.jsonl`) into the generated part of `docs/error-estimate.md`.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::Path;

use dcb_tests::accuracy::sections;
use dcb_tests::error_estimate;

const COMMAND: &str = "cargo run --release -p dcb-tests --example error_estimate";

fn main() {
    if std::env::args().any(|argument| argument == "--render") {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
        let raw = std::fs::read_to_string(docs.join("data/error_estimate.jsonl"))
            .expect("data/error_estimate.jsonl");
        print!("{}", error_estimate::render(&raw));
        return;
    }
    println!("{}", sections::machine(COMMAND));
    for line in error_estimate::lines() {
        println!("{line}");
    }
}
