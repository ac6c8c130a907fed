//! `docs/data/error_estimate.jsonl` as the generated part of `docs/error-estimate.md`.

use serde_json::Value;

use super::{Page, raw_lines, table};

/// The generated part of `docs/error-estimate.md`.
pub const PAGE: Page = Page {
    page: "error-estimate.md",
    data: "error_estimate",
    markers: [
        "<!-- generated from data/error_estimate.jsonl -->\n",
        "<!-- end of the generated part -->\n",
    ],
    render,
    pictures: |_| Vec::new(),
};

fn render(raw: &str) -> String {
    let lines = raw_lines(raw);
    let lines: Vec<&Value> = lines
        .iter()
        .filter(|line| line["part"].is_string())
        .collect();
    let number = |line: &Value, key: &str| line[key].as_f64().unwrap_or(f64::NAN);
    let mut page = String::new();
    let mut groups: Vec<Vec<&Value>> = Vec::new();
    let key = |line: &Value| ["part", "form", "band"].map(|key| line[key].to_string());
    for line in &lines {
        match groups.last_mut() {
            Some(group) if key(group[0]) == key(line) => group.push(line),
            _ => groups.push(vec![line]),
        }
    }
    let rows: Vec<Vec<String>> = groups
        .iter()
        .map(|group| {
            let first = group[0];
            let mut row = vec![
                first["part"].as_str().unwrap_or("").to_owned(),
                first["modes"].to_string(),
                first["form"].as_str().unwrap_or("").to_owned(),
                format!("{:.2}", number(first, "band")),
            ];
            for measure in ["held", "collocated", "transfer"] {
                let found = group.iter().find(|line| line["measure"] == measure);
                row.push(found.map_or(String::new(), |line| {
                    let truth = number(line, "true");
                    format!(
                        "{truth:.1e} ({:.3}, {:.3})",
                        number(line, "lower") / truth,
                        number(line, "upper") / truth
                    )
                }));
            }
            row
        })
        .collect();
    page += &table(
        &[
            "part",
            "modes",
            "form",
            "band",
            "held frequency",
            "collocated",
            "transfer",
        ],
        &rows,
    );
    let fixed = lines.iter().filter(|line| line["measure"] == "static");
    let all: Vec<[f64; 2]> = fixed
        .filter(|line| {
            !line["part"]
                .as_str()
                .unwrap_or("")
                .contains("interface modes")
        })
        .map(|line| [number(line, "true"), number(line, "upper")])
        .collect();
    let largest = |which: usize| all.iter().map(|both| both[which]).fold(0.0, f64::max);
    page + &format!(
        "\nStatic responses with all attachments: true errors up to {:.1e}, bounds up to {:.1e}, which is rounding in K.\n",
        largest(0),
        largest(1)
    )
}
