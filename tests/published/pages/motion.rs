//! Do `docs/accuracy.md` and its pictures show what `docs/data/motion.jsonl` holds, and is all of it within its bounds?

use dcb_tests::motion::pictures;
use dcb_tests::pages::motion::{MARKERS, render};
use serde_json::Value;

fn docs(file: &str) -> String {
    std::fs::read_to_string(format!("{}/../docs/{file}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

#[test]
fn the_page_is_what_the_raw_lines_render_to() {
    let page = docs("accuracy.md");
    let (_, rest) = page.split_once(MARKERS[0]).expect("the first marker");
    let (generated, _) = rest.split_once(MARKERS[1]).expect("the second marker");
    assert!(
        generated == render(&docs("data/motion.jsonl")),
        "paste what `--example motion -- --render` prints"
    );
}

#[test]
fn the_pictures_are_what_the_raw_lines_draw() {
    let raw = docs("data/motion.jsonl");
    let folder = tempfile::tempdir().unwrap();
    pictures::write(&raw, folder.path());
    let page = docs("accuracy.md");
    for (name, _) in pictures::pictures(&raw) {
        let drawn = std::fs::read_to_string(folder.path().join(name)).unwrap();
        assert!(drawn == docs(&format!("pictures/{name}")), "{name}");
        assert!(page.contains(&format!("(pictures/{name})")), "{name}");
    }
}

#[test]
fn every_raw_line_is_within_its_bound() {
    let raw = docs("data/motion.jsonl");
    let first = raw.lines().next().unwrap();
    assert!(first.contains("\"machine\""));
    for line in raw.lines() {
        let value: Value = serde_json::from_str(line).unwrap();
        for prefix in ["", "classical_", "slider_", "static_"] {
            if let Some(bound) = value[format!("{prefix}bound")].as_f64() {
                // NaN is written as null.
                let error = value[format!("{prefix}error")].as_f64();
                assert!(error.is_some_and(|error| error <= bound), "{line}");
            }
        }
    }
}
