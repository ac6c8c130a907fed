//! Runs the paper's weak form over a grid of steps, spectral radii and modes, and measures what the step, the spectral radius and the level
//! of the constraints do to the default form, one JSON line each; with `--render`, turns such lines (`docs/data/weak_form_map.jsonl`) into
//! the generated parts of `docs/stability.md` and the picture.

use dcb_tests::accuracy::sections;
use dcb_tests::hard::dynamics::weak_form_map;
use dcb_tests::pages::{pictures_folder, stability};

const COMMAND: &str = "cargo run --release -p dcb-tests --example weak_form_map";

fn main() {
    if std::env::args().any(|argument| argument == "--render") {
        stability::PAGE.draw(&pictures_folder());
        print!("{}", stability::PAGE.rendered());
        print!("{}", stability::RULES.markers[0]);
        print!("{}", stability::RULES.rendered());
        return;
    }
    println!("{}", sections::machine(COMMAND));
    for line in weak_form_map::lines(&weak_form_map::FULL) {
        println!("{line}");
    }
}
