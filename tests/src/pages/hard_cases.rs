//! `docs/data/hard_cases.jsonl` as the tables of `docs/hard-cases.md`.

use serde_json::Value;

use super::{Page, machine, raw_lines, rows, table, text};

/// The generated part of `docs/hard-cases.md`.
pub const PAGE: Page = Page {
    page: "hard-cases.md",
    data: "hard_cases",
    markers: [
        "<!-- generated from data/hard_cases.jsonl -->\n",
        "<!-- end of the generated part -->\n",
    ],
    render,
    pictures: |_| Vec::new(),
};

/// The machine, then one table for each group in the order in which they appear.
fn render(raw: &str) -> String {
    let lines = raw_lines(raw);
    let (machines, cases): (Vec<&Value>, Vec<&Value>) =
        lines.iter().partition(|line| line["kind"] == "machine");
    let mut page = String::new();
    machines.into_iter().for_each(|line| page += &machine(line));
    let mut groups: Vec<String> = cases.iter().map(|line| text(line, "group")).collect();
    groups.dedup();
    for group in groups {
        let own: Vec<&Value> = cases
            .iter()
            .copied()
            .filter(|line| line["group"] == group.as_str())
            .collect();
        page += &format!("\n## {}\n\n", titled(&group));
        page += &table(
            &[
                "case",
                "plain method",
                "its outcome",
                "ours",
                "error",
                "bound",
            ],
            &rows(&own, row),
        );
    }
    page
}

/// With a capital.
fn titled(group: &str) -> String {
    let mut letters = group.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().collect::<String>() + letters.as_str()
    })
}

fn row(line: &Value) -> Vec<String> {
    let cell = |key: &str| text(line, key).replace('|', "\\|");
    let number = |key: &str, digits: usize| {
        line[key]
            .as_f64()
            .map_or("–".to_owned(), |value| format!("{value:.digits$e}"))
    };
    vec![
        cell("name").replace('_', " "),
        cell("naive_method"),
        cell("naive"),
        cell("ours"),
        number("error", 1),
        number("bound", 1),
    ]
}
