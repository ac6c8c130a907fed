//! Turns the lines of `docs/data/scene_reduction.jsonl`, which `tests/reduction/scene_driven.rs` prints, and `docs/data/scene_driven.jsonl`,
//! which `tests/benches/scene_driven.py` measures, into the generated parts of `docs/scene-driven.md` (printed, in this order).

use dcb_tests::pages::{scene_driven, scene_reduction};

fn main() {
    println!("{}", scene_reduction::PAGE.rendered());
    print!("{}", scene_driven::PAGE.rendered());
}
