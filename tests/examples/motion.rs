//! Measures motions against references, closed forms and conserved quantities, one JSON line per quantity or curve; with
//! `--render`, turns such lines (`docs/data/motion.jsonl`) into the second generated part of `docs/accuracy.md` and its pictures.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::Path;

use dcb_tests::accuracy::sections;
use dcb_tests::motion::{deflection, invariance, order, pictures, published};
use dcb_tests::pages::motion;

const COMMAND: &str = "cargo run --release -p dcb-tests --example motion";

fn main() {
    if std::env::args().any(|argument| argument == "--render") {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
        let raw =
            std::fs::read_to_string(docs.join("data/motion.jsonl")).expect("data/motion.jsonl");
        pictures::write(&raw, &docs.join("pictures"));
        print!("{}", motion::render(&raw));
        return;
    }
    println!("{}", sections::machine(COMMAND));
    for section in [
        deflection::step_convergence,
        deflection::unreduced,
        deflection::classical,
        deflection::reduced,
        deflection::weak,
        published::test_set,
        published::elements,
        published::rigid,
        published::flexible,
        order::order,
        invariance::invariance,
    ] {
        section().iter().for_each(|line| println!("{line}"));
    }
}
