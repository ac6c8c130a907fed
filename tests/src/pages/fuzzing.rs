//! `docs/data/fuzzing.jsonl` as a generated part of `docs/hostile-files.md`.

use super::{Page, raw_lines, table, text};

/// How many inputs each reader of other programs' files was tried with.
pub const PAGE: Page = Page {
    page: "hostile-files.md",
    data: "fuzzing",
    markers: [
        "<!-- generated from data/fuzzing.jsonl -->\n",
        "<!-- end of the generated part -->\n",
    ],
    render,
    pictures: |_| Vec::new(),
};

fn render(raw: &str) -> String {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for line in raw_lines(raw) {
        rows.push(vec![
            format!("`{}`", text(&line, "command")),
            text(&line, "commit"),
            format!("{:.0e}", line["inputs"].as_f64().expect("inputs")),
            line["seconds"].to_string(),
            line["slowest_s"].to_string(),
            line["peak_mb"].to_string(),
        ]);
    }
    table(
        &[
            "command",
            "commit",
            "inputs",
            "seconds",
            "slowest input [s]",
            "most memory [MB]",
        ],
        &rows,
    )
}
