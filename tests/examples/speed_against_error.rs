//! Turns the lines of `docs/data/speed_against_error.jsonl`, which `tests/benches/speed_against_error.py` measures, into the generated part
//! of `docs/speed-against-error.md` (printed) and its pictures.

use dcb_tests::pages::{pictures_folder, speed_against_error};

fn main() {
    speed_against_error::PAGE.draw(&pictures_folder());
    print!("{}", speed_against_error::PAGE.rendered());
}
