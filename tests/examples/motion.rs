//! Measures motions against references, closed forms and conserved quantities, one JSON line per quantity or curve; with
//! `--render`, turns such lines (`docs/data/motion.jsonl`) into the second generated part of `docs/accuracy.md` and its pictures.

use dcb_tests::accuracy::sections;
use dcb_tests::motion::{deflection, invariance, order, published};
use dcb_tests::pages::{motion, pictures_folder};

const COMMAND: &str = "cargo run --release -p dcb-tests --example motion";

fn main() {
    if std::env::args().any(|argument| argument == "--render") {
        motion::PAGE.draw(&pictures_folder());
        print!("{}", motion::PAGE.rendered());
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
