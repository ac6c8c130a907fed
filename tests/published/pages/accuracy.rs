//! Does `docs/accuracy.md` show what `docs/data/accuracy.jsonl` holds, and is all of it within its bounds?

use dcb_tests::pages::accuracy::{MARKERS, render};
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
        generated == render(&docs("data/accuracy.jsonl")),
        "paste what `--example accuracy -- --render` prints"
    );
    assert!(generated.lines().count() < 100);
}

#[test]
fn every_raw_line_is_within_its_bound() {
    let raw = docs("data/accuracy.jsonl");
    assert!(
        raw.lines()
            .next()
            .is_some_and(|line| line.contains("\"machine\""))
    );
    for line in raw.lines() {
        let value: Value = serde_json::from_str(line).unwrap();
        if let Some(bound) = value["bound"].as_f64() {
            // NaN is written as null.
            let error = value["relative_error"].as_f64();
            assert!(error.is_some_and(|error| error <= bound), "{line}");
        }
        assert!(
            value["equal"] != false && value["identical"] != false,
            "{line}"
        );
    }
}
