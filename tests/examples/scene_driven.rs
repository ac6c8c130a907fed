//! Turns the lines of `docs/data/scene_driven.jsonl`, which `tests/benches/scene_driven.py` measures, into the generated part of
//! `docs/scene-driven.md` (printed).
#![allow(clippy::unwrap_used, clippy::expect_used)]

use dcb_tests::scene_driven_page;

fn main() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../docs/data/scene_driven.jsonl"
    );
    let raw = std::fs::read_to_string(path).unwrap();
    print!("{}", scene_driven_page::render(&raw));
}
