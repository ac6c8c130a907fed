//! Measures reductions against references and dense algebra, one JSON line per quantity; with `--render`, turns such lines
//! (`docs/data/accuracy.jsonl`) into the generated part of `docs/accuracy.md`.

use dcb_tests::accuracy::cases as dense;
use dcb_tests::accuracy::{references, sections};
use dcb_tests::pages::accuracy;

const COMMAND: &str = "cargo run --release -p dcb-tests --example accuracy";

fn main() {
    if std::env::args().any(|argument| argument == "--render") {
        print!("{}", accuracy::PAGE.rendered());
        return;
    }
    println!("{}", sections::machine(COMMAND));
    for section in [
        references::published_rotor,
        references::reference_values,
        sections::closed_forms,
        sections::unit_systems,
        sections::thread_counts,
    ] {
        section().iter().for_each(|line| println!("{line}"));
    }
    println!("{}", dense::ring().line());
    for case in dense::cases() {
        for line in case.measure() {
            println!("{}", line.line());
        }
    }
}
