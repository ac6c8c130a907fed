//! Turns the lines of `docs/data/scene_reduction.jsonl`, which `tests/reduction/scene_driven.rs` prints, and `docs/data/scene_driven.jsonl`,
//! which `tests/benches/scene_driven.py` measures, into the generated parts of `docs/scene-driven.md` (printed, in this order).
#![allow(clippy::unwrap_used, clippy::expect_used)]

use dcb_tests::pages::{scene_driven, scene_reduction};

fn main() {
    let raw = |name: &str| {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/data");
        std::fs::read_to_string(format!("{folder}/{name}.jsonl")).unwrap()
    };
    println!("{}", scene_reduction::render(&raw("scene_reduction")));
    print!("{}", scene_driven::render(&raw("scene_driven")));
}
