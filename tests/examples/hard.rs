//! Runs every hard case and writes one JSON line each into `docs/data/hard_cases.jsonl`; with `--render`, turns these lines into the
//! generated part of `docs/hard-cases.md`.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use dcb_tests::accuracy::sections;
use dcb_tests::hard::case::HardCase;
use dcb_tests::hard::{dynamics, reduction};
use dcb_tests::pages::hard_cases;

const COMMAND: &str = "cargo run --release -p dcb-tests --example hard";

/// Group by group, in the order of the page.
fn cases() -> Vec<fn() -> HardCase> {
    [reduction::cases(), dynamics::cases()].concat()
}

fn main() {
    let path = format!(
        "{}/../docs/data/hard_cases.jsonl",
        env!("CARGO_MANIFEST_DIR")
    );
    if std::env::args().any(|argument| argument == "--render") {
        let raw = std::fs::read_to_string(path).expect("docs/data/hard_cases.jsonl");
        print!("{}", hard_cases::render(&raw));
        return;
    }
    let mut lines = format!("{}\n", sections::machine(COMMAND));
    for case in cases() {
        lines += &format!("{}\n", case().line());
    }
    std::fs::write(path, lines).expect("docs/data/hard_cases.jsonl");
}
