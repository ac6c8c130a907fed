//! Does `docs/hard-cases.md` show what `docs/data/hard_cases.jsonl` holds, and is all of it within its bounds?

use dcb_tests::pages::hard_cases::{MARKERS, render};
use serde_json::Value;

fn docs(file: &str) -> String {
    std::fs::read_to_string(format!("{}/../docs/{file}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

#[test]
fn the_page_is_what_the_raw_lines_render_to() {
    let page = docs("hard-cases.md");
    let (_, rest) = page.split_once(MARKERS[0]).expect("the first marker");
    let (generated, _) = rest.split_once(MARKERS[1]).expect("the second marker");
    assert!(
        generated == render(&docs("data/hard_cases.jsonl")),
        "paste what `--example hard -- --render` prints"
    );
}

#[test]
fn every_raw_line_is_within_its_bound() {
    let raw = docs("data/hard_cases.jsonl");
    let lines: Vec<Value> = raw
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(lines[0]["kind"], "machine");
    assert!(lines.len() > 20);
    for line in &lines[1..] {
        match line["bound"].as_f64() {
            // NaN is written as null.
            Some(bound) => {
                let error = line["error"].as_f64();
                assert!(error.is_some_and(|error| error <= bound), "{line}");
            }
            None => {
                let ours = line["ours"].as_str().unwrap();
                assert!(ours.contains("refused") || ours.contains("told"), "{line}");
            }
        }
    }
}
