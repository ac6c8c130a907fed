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
    if std::env::args().any(|argument| argument == "--render") {
        print!("{}", hard_cases::PAGE.rendered());
        return;
    }
    let mut lines = format!("{}\n", sections::machine(COMMAND));
    for case in cases() {
        lines += &format!("{}\n", case().line());
    }
    std::fs::write(hard_cases::PAGE.data_path(), lines).expect("docs/data/hard_cases.jsonl");
}
