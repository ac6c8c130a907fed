//! `docs/data/damping.jsonl` as a generated part of `docs/damping.md`.

use serde_json::Value;

use super::{Page, raw_lines, table};

/// The generated part of `docs/damping.md`.
pub const PAGE: Page = Page {
    page: "damping.md",
    data: "damping",
    markers: [
        "<!-- generated from data/damping.jsonl -->\n",
        "<!-- end of the generated part -->\n",
    ],
    render,
    pictures: |_| Vec::new(),
};

fn render(raw: &str) -> String {
    let lines = raw_lines(raw);
    let of = |kind: &str| -> Vec<&Value> {
        let own = lines.iter().filter(|line| line["kind"] == kind);
        own.collect()
    };
    let numbers = |value: &Value| -> Vec<f64> {
        let list = value.as_array().cloned().unwrap_or_default();
        list.iter().filter_map(Value::as_f64).collect()
    };
    let mut page = String::new();
    for line in of("conditions") {
        page += &format!(
            "`{}` at commit {}.\n\n",
            line["command"].as_str().unwrap_or("").trim(),
            line["commit"].as_str().unwrap_or("")
        );
    }
    let rows = of("damping");
    let mut heading = vec!["ratio at".to_owned()];
    if let Some(first) = rows.first() {
        let frequencies = numbers(&first["hertz"]);
        heading.extend(frequencies.iter().map(|hertz| format!("{hertz:.2} Hz")));
    }
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let ratios = numbers(&row["ratios"]);
            let name = row["of"].as_str().unwrap_or("").to_owned();
            std::iter::once(name)
                .chain(ratios.iter().map(|ratio| match *ratio < 1e-7 {
                    true => "0".to_owned(),
                    false => format!("{ratio:.5}"),
                }))
                .collect()
        })
        .collect();
    let heading: Vec<&str> = heading.iter().map(String::as_str).collect();
    page + &table(&heading, &cells)
}
