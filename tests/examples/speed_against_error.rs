//! Turns the lines of `docs/data/speed_against_error.jsonl`, which `tests/benches/speed_against_error.py` measures, into the generated part
//! of `docs/speed-against-error.md` (printed) and its pictures.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::Path;

use dcb_tests::pages::speed_against_error;

fn main() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let raw = std::fs::read_to_string(docs.join("data/speed_against_error.jsonl")).unwrap();
    speed_against_error::write(&raw, &docs.join("pictures"));
    print!("{}", speed_against_error::render(&raw));
}
