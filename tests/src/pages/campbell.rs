//! `docs/data/campbell.jsonl` as a generated part of `docs/rotors.md`.

use serde_json::Value;

use super::{Page, raw_lines, table};

/// The generated part of `docs/rotors.md`.
pub const PAGE: Page = Page {
    page: "rotors.md",
    data: "campbell",
    markers: [
        "<!-- generated from data/campbell.jsonl -->\n",
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
    let text = |value: &Value| value.as_str().unwrap_or("").to_owned();
    let number = |line: &Value, key: &str| line[key].as_f64().unwrap_or(f64::NAN);
    let off =
        |line: &Value, to: &str| format!("{:.1e}", number(line, "ours") / number(line, to) - 1.0);
    let mut page = String::new();
    for line in of("conditions") {
        page += &format!(
            "`{}` at commit {}, {}, {} cores; ROSS {}. `simulate campbell` took {:.2} s.\n\n",
            text(&line["command"]),
            text(&line["commit"]),
            text(&line["machine"]["cpu"]),
            line["machine"]["cores"],
            text(&line["versions"]["ross"]),
            number(line, "seconds")
        );
    }
    page += "Angular frequencies at 4000 rpm beside those that the documentation of ROSS publishes, of six Timoshenko elements with gyroscopic moments of the shaft:\n\n";
    let cells: Vec<Vec<String>> = (of("published").into_iter())
        .map(|line| {
            vec![
                line["mode"].to_string(),
                format!("{:.4}", number(line, "published")),
                format!("{:.4}", number(line, "ours")),
                off(line, "published"),
            ]
        })
        .collect();
    page += &table(
        &["mode", "published [rad/s]", "ours [rad/s]", "difference"],
        &cells,
    );
    page += "\nFrequencies and critical speeds beside ROSS with the elements of our shaft (Euler–Bernoulli, no rotary inertia):\n\n";
    let mut cells: Vec<Vec<String>> = (of("whirl").into_iter())
        .map(|line| {
            vec![
                format!("mode {} at {} rpm [Hz]", line["mode"], line["rpm"]),
                format!("{:.4}", number(line, "ross")),
                format!("{:.4}", number(line, "ours")),
                off(line, "ross"),
            ]
        })
        .collect();
    cells.extend(of("critical").into_iter().map(|line| {
        vec![
            format!("critical speed of order {} [rpm]", number(line, "order")),
            format!("{:.2}", number(line, "ross")),
            format!("{:.2}", number(line, "ours")),
            off(line, "ross"),
        ]
    }));
    page + &table(&["", "ROSS", "ours", "difference"], &cells)
}
