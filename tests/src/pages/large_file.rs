//! `docs/data/large_file.jsonl` as a generated part of `docs/format.md`.

use serde_json::Value;

use super::{Page, raw_lines, table};

/// The generated part of `docs/format.md`.
pub const PAGE: Page = Page {
    page: "format.md",
    data: "large_file",
    markers: [
        "<!-- generated from data/large_file.jsonl -->\n",
        "<!-- end of the generated part -->\n",
    ],
    render,
    pictures: |_| Vec::new(),
};

fn render(raw: &str) -> String {
    let lines = raw_lines(raw);
    let mut page = String::new();
    for line in lines.iter().filter(|line| line["kind"] == "conditions") {
        let words = |value: &Value| value.as_str().unwrap_or("").trim().to_owned();
        page += &format!(
            "`{}` at commit {}, {}, {} cores.\n\n",
            words(&line["command"]),
            words(&line["commit"]),
            words(&line["machine"]["cpu"]),
            line["machine"]["cores"],
        );
    }
    let runs = lines.iter().filter(|line| line["kind"] == "run");
    let cells: Vec<Vec<String>> = runs
        .map(|run| {
            let words = |key: &str| run[key].as_str().unwrap_or("").to_owned();
            let amount = |key: &str| run[key].as_f64().unwrap_or(f64::NAN);
            vec![
                words("scene"),
                words("file"),
                format!("{:.1}", amount("file_bytes") / 1e6),
                words("cache"),
                format!("{:.2}", amount("bytes_read") / 1e6),
                format!("{:.1}", amount("seconds") * 1e3),
            ]
        })
        .collect();
    page + &table(
        &[
            "scene names",
            "file",
            "of [MB]",
            "system's cache",
            "read [MB]",
            "whole process [ms]",
        ],
        &cells,
    )
}
