//! `docs/data/read_matrices.jsonl` as a generated part of `docs/import.md`.

use serde_json::Value;

use super::{Page, raw_lines, table, text};

/// How fast other programs' matrices are read.
pub const PAGE: Page = Page {
    page: "import.md",
    data: "read_matrices",
    markers: [
        "<!-- generated from data/read_matrices.jsonl -->\n",
        "<!-- end of what is generated from data/read_matrices.jsonl -->\n",
    ],
    render,
    pictures: |_| Vec::new(),
};

/// Most time for a megabyte of text, over that of Matrix Market.
pub const TEXT_LIMIT: f64 = 1.5;
/// Most time of a binary file, over that of a copy in memory.
pub const BINARY_LIMIT: f64 = 3.0;
/// Most memory, over the matrix in full storage.
pub const MEMORY_LIMIT: f64 = 2.0;

fn render(raw: &str) -> String {
    let lines = raw_lines(raw);
    let conditions = &lines[0];
    let mut page = format!(
        "`{}`, commit {}, {}, {} cores, {}; NumPy {}, SciPy {}, h5py {}, pyyeti {}, pyNastran {}.\n\n",
        text(conditions, "command"),
        text(conditions, "commit"),
        text(conditions, "cpu"),
        conditions["cores"],
        text(conditions, "rustc"),
        text(conditions, "numpy"),
        text(conditions, "scipy"),
        text(conditions, "h5py"),
        text(conditions, "pyyeti"),
        text(conditions, "pyNastran"),
    );
    page += &format!(
        "Text, against Matrix Market (limit: {TEXT_LIMIT} times its time for a megabyte) and the usual reader in Python:\n\n"
    );
    page += &of_kind(&lines, "text", "time_per_mb_to_market", TEXT_LIMIT);
    page += &format!(
        "\nBinary, against reading the bytes and copying them once in memory (limit: {BINARY_LIMIT} times):\n\n"
    );
    page + &of_kind(&lines, "binary", "time_to_copy", BINARY_LIMIT)
}

fn of_kind(lines: &[Value], kind: &str, ratio: &str, limit: f64) -> String {
    let rows: Vec<Vec<String>> = lines
        .iter()
        .filter(|line| line["kind"] == kind)
        .map(|line| {
            let number = |key: &str| line[key].as_f64().expect(key);
            let memory = number("whole_memory");
            // In small files what a process takes anyway counts.
            let is_large = number("file_mb") > 20.0;
            vec![
                text(line, "format"),
                format!("{:.0}", number("file_mb")),
                format!("{:.0}", number("mb_per_s")),
                match is_large {
                    true => missed(number(ratio), limit),
                    false => format!("{:.2}", number(ratio)),
                },
                match is_large {
                    true => missed(memory, MEMORY_LIMIT),
                    false => String::new(),
                },
                line["peer_to_ours"].as_f64().map_or(String::new(), |peer| {
                    format!("{} {peer:.1}", text(line, "peer"))
                }),
            ]
        })
        .collect();
    let against = match kind {
        "text" => "time / Matrix Market's, for a MB",
        _ => "time / copy's",
    };
    table(
        &[
            "format",
            "MB",
            "MB/s",
            against,
            "memory / matrix",
            "peer's time / ours",
        ],
        &rows,
    )
}

/// A ratio, with a word where it is above its limit.
fn missed(ratio: f64, limit: f64) -> String {
    match ratio <= limit {
        true => format!("{ratio:.2}"),
        false => format!("**{ratio:.2}**, missed"),
    }
}
