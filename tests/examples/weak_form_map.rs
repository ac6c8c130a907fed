//! Runs the paper's weak form over a grid of steps, spectral radii and modes, and measures what the step, the spectral radius and the level
//! of the constraints do to the default form, one JSON line each; with `--render`, turns such lines (`docs/data/weak_form_map.jsonl`) into
//! the generated parts of `docs/stability.md` and the picture.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::Path;

use dcb_tests::accuracy::sections;
use dcb_tests::hard::dynamics::weak_form_map;

const COMMAND: &str = "cargo run --release -p dcb-tests --example weak_form_map";

fn main() {
    if std::env::args().any(|argument| argument == "--render") {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
        let raw = std::fs::read_to_string(docs.join("data/weak_form_map.jsonl"))
            .expect("data/weak_form_map.jsonl");
        weak_form_map::write_picture(&raw, &docs.join("pictures"));
        print!("{}", weak_form_map::render(&raw));
        print!("{}", weak_form_map::RULE_MARKERS[0]);
        print!("{}", weak_form_map::render_rules(&raw));
        return;
    }
    println!("{}", sections::machine(COMMAND));
    for line in weak_form_map::lines(&weak_form_map::FULL) {
        println!("{line}");
    }
}
