//! `docs/data/stress.jsonl` as a generated part of `docs/stress.md`.

use serde_json::Value;

use super::{Page, raw_lines, table};

/// The generated part of `docs/stress.md`.
pub const PAGE: Page = Page {
    page: "stress.md",
    data: "stress",
    markers: [
        "<!-- generated from data/stress.jsonl -->\n",
        "<!-- end of the generated part -->\n",
    ],
    render,
    pictures: |_| Vec::new(),
};

fn render(raw: &str) -> String {
    let lines = raw_lines(raw);
    let words = |value: &Value| value.as_str().unwrap_or("").trim().to_owned();
    let mut page = String::new();
    for line in lines.iter().filter(|line| line["kind"] == "conditions") {
        page += &format!(
            "`{}` at commit {}, {}, {} cores: {} degrees of freedom, {} places.\n\n",
            words(&line["command"]),
            words(&line["commit"]),
            words(&line["machine"]["cpu"]),
            line["machine"]["cores"],
            line["dofs"],
            line["places"]
        );
    }
    let errors: Vec<&Value> = lines
        .iter()
        .filter(|line| line["kind"] == "error")
        .collect();
    let mut frequencies: Vec<f64> = errors
        .iter()
        .filter_map(|line| line["hertz"].as_f64())
        .collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup();
    let mut modes: Vec<u64> = errors
        .iter()
        .filter_map(|line| line["modes"].as_u64())
        .collect();
    modes.dedup();
    let mut heading = vec!["modes".to_owned(), "with attachments".to_owned()];
    heading.extend(frequencies.iter().map(|hertz| match *hertz {
        0.0 => "at rest".to_owned(),
        hertz => format!("{hertz} Hz"),
    }));
    let mut cells = Vec::new();
    for count in modes {
        for (key, name) in [("with", "yes"), ("without", "no")] {
            let of = |hertz: &f64| {
                let line = errors.iter().find(|line| {
                    line["modes"].as_u64() == Some(count) && line["hertz"].as_f64() == Some(*hertz)
                });
                line.and_then(|line| line[key].as_f64())
            };
            let row: Vec<Option<f64>> = frequencies.iter().map(of).collect();
            if row.iter().all(Option::is_none) {
                continue;
            }
            let mut cell = vec![count.to_string(), name.to_owned()];
            cell.extend(row.into_iter().map(|value| match value {
                Some(value) => format!("{value:.1e}"),
                None => "-".to_owned(),
            }));
            cells.push(cell);
        }
    }
    let heading: Vec<&str> = heading.iter().map(String::as_str).collect();
    page += &table(&heading, &cells);
    let bounds: Vec<Vec<String>> = (lines.iter())
        .filter(|line| line["kind"] == "bound" && line["told"] != "")
        .map(|line| {
            let told = words(&line["told"]);
            let bound = told.rsplit("; ").next().unwrap_or("").to_owned();
            vec![line["modes"].to_string(), bound]
        })
        .collect();
    if !bounds.is_empty() {
        page.push('\n');
        page += &table(&["modes", "bound that `reduce inspect` tells"], &bounds);
    }
    page
}
