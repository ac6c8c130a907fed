//! Does `docs/format.md` show what `docs/data/large_file.jsonl` holds, and does that keep what is promised?

use dcb_tests::pages::large_file::{MARKERS, render};
use dcb_tests::raw_lines::raw_lines;
use serde_json::Value;

fn docs(file: &str) -> String {
    std::fs::read_to_string(format!("{}/../docs/{file}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

#[test]
fn the_page_is_what_the_raw_lines_render_to() {
    let page = docs("format.md");
    let (_, rest) = page.split_once(MARKERS[0]).expect("the first marker");
    let (generated, _) = rest.split_once(MARKERS[1]).expect("the second marker");
    let expected = render(&docs("data/large_file.jsonl"));
    assert!(generated == expected, "paste this:\n{expected}");
}

#[test]
fn a_scene_of_two_interfaces_reads_as_little_of_a_large_file() {
    let lines = raw_lines(&docs("data/large_file.jsonl"));
    let number = |file: &str, key: &str| {
        let is_wanted = |line: &&Value| {
            line["scene"] == "two interfaces" && line["file"] == file && line["cache"] == "warm"
        };
        lines.iter().find(is_wanted).unwrap()[key].as_f64().unwrap()
    };
    assert!(number("large", "file_bytes") > 2e9);
    let more = number("large", "bytes_read") - number("small", "bytes_read");
    assert!(more < 1e5, "{more} bytes more than of the small file");
    let more = number("large", "seconds") - number("small", "seconds");
    assert!(more < 0.01, "{more} s more than with the small file");
}
