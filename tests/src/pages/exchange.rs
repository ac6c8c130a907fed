//! `docs/data/exchange.jsonl` as tables of formats: read in `docs/import.md`, written in `docs/export.md`.

use serde_json::Value;

use super::{Page, raw_lines, table, text};

const MARKERS: [&str; 2] = [
    "<!-- generated from data/exchange.jsonl -->\n",
    "<!-- end of the generated part -->\n",
];

/// The generated part of `docs/import.md`.
pub const READ: Page = Page {
    page: "import.md",
    data: "exchange",
    markers: MARKERS,
    render: read,
    pictures: |_| Vec::new(),
};

/// The generated part of `docs/export.md`.
pub const WRITTEN: Page = Page {
    page: "export.md",
    data: "exchange",
    markers: MARKERS,
    render: written,
    pictures: |_| Vec::new(),
};

fn conditions(lines: &[Value]) -> String {
    let line = &lines[0];
    let versions = line.as_object().expect("an object").iter();
    let versions: Vec<String> = versions
        .filter(|(key, _)| !matches!(key.as_str(), "kind" | "command" | "commit" | "date"))
        .map(|(name, version)| format!("{name} {}", version.as_str().unwrap_or("missing")))
        .collect();
    format!(
        "`{}`, commit {}, {}.\n\n",
        text(line, "command"),
        text(line, "commit"),
        versions.join(", ")
    )
}

fn of<'a>(lines: &'a [Value], kind: &'a str) -> impl Iterator<Item = &'a Value> {
    lines.iter().filter(move |line| line["kind"] == kind)
}

/// Equality to the last bit in a word.
fn error(value: &Value) -> String {
    match value.as_f64() {
        Some(0.0) => "0, every bit".into(),
        Some(error) => format!("{error:.0e}"),
        None => "".into(),
    }
}

fn read(raw: &str) -> String {
    let lines = raw_lines(raw);
    let mut page = conditions(&lines);
    page += "Matrices of one part, the bracket, against `bracket.mtx` (largest difference over the largest entry):\n\n";
    let rows: Vec<Vec<String>> = of(&lines, "matrix")
        .map(|line| {
            vec![
                text(line, "format"),
                text(line, "written_by"),
                error(&line["stiffness_error"]),
                error(&line["mass_error"]),
                format!("{:.0e}", line["k_r"].as_f64().expect("K R")),
            ]
        })
        .collect();
    page += &table(
        &["format", "file written by", "K off by", "M off by", "K R"],
        &rows,
    );
    page += "\nFiles of real programs, reduced; the lowest free elastic frequencies against a reference:\n\n";
    let rows: Vec<Vec<String>> = of(&lines, "real")
        .map(|line| {
            vec![
                text(line, "format"),
                text(line, "written_by"),
                text(line, "against"),
                line["frequencies"].to_string(),
                error(&line["frequency_error"]),
                format!("{:.0e}", line["k_r"].as_f64().expect("K R")),
            ]
        })
        .collect();
    page += &table(
        &[
            "file",
            "written by",
            "reference",
            "frequencies",
            "off by",
            "K R",
        ],
        &rows,
    );
    page += "\nMeshes of the bracket against `bracket.json` (over the part's size):\n\n";
    let rows: Vec<Vec<String>> = of(&lines, "mesh")
        .map(|line| {
            let sets = line["sets"].as_array().expect("sets").iter();
            let sets: Vec<&str> = sets.filter_map(Value::as_str).collect();
            vec![
                text(line, "format"),
                text(line, "written_by"),
                error(&line["point_error"]),
                match sets.is_empty() {
                    true => "none".into(),
                    false => sets.join(", "),
                },
            ]
        })
        .collect();
    page + &table(&["mesh", "file written by", "places off by", "sets"], &rows)
}

fn written(raw: &str) -> String {
    let lines = raw_lines(raw);
    let mut page = conditions(&lines);
    page += "The rotor with 12 modes. *File*: each number against the superelement's own, by parsers that share no code with the exporters (`tests/h5py/exports.py`); largest relative difference.\n\n";
    let mut rows: Vec<Vec<String>> = Vec::new();
    for line in of(&lines, "export") {
        let dialect = line["dialect"].as_str();
        let target = text(line, "target");
        rows.push(vec![
            dialect.map_or(target.clone(), |dialect| format!("{target}, {dialect}")),
            "the file".into(),
            error(&line["error"]),
        ]);
    }
    for line in of(&lines, "client") {
        let found = match line["errors"].as_object() {
            None => format!("not run: {}", text(line, "why")),
            Some(errors) => {
                let errors: Vec<String> = errors
                    .iter()
                    .map(|(name, value)| format!("{name} {}", error(value)))
                    .collect();
                errors.join("; ")
            }
        };
        rows.push(vec![text(line, "target"), text(line, "client"), found]);
    }
    page += &table(&["`--to`", "read by", "off by"], &rows);
    page
}
