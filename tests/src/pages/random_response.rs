//! `docs/data/random_response.jsonl` as a generated part of `docs/frequency-response.md`.

use serde_json::Value;

use super::{Page, raw_lines, table};

/// The generated part of `docs/frequency-response.md`.
pub const PAGE: Page = Page {
    page: "frequency-response.md",
    data: "random_response",
    markers: [
        "<!-- generated from data/random_response.jsonl -->\n",
        "<!-- end of the part on random responses -->\n",
    ],
    render,
    pictures: |_| Vec::new(),
};

fn render(raw: &str) -> String {
    let lines = raw_lines(raw);
    let mut page = String::new();
    let words = |value: &Value| value.as_str().unwrap_or("").trim().to_owned();
    for line in lines.iter().filter(|line| line["kind"] == "conditions") {
        page += &format!(
            "`{}` at commit {}, {}, {} cores.\n\n",
            words(&line["command"]),
            words(&line["commit"]),
            words(&line["machine"]["cpu"]),
            line["machine"]["cores"]
        );
    }
    let amount = |line: &Value, key: &str| line[key].as_f64().unwrap_or(f64::NAN);
    let cells: Vec<Vec<String>> = (lines.iter())
        .filter_map(|line| {
            let (rms, crossings) = (amount(line, "rms"), amount(line, "zero_crossings"));
            let row = |name: String, seconds: String| {
                vec![
                    name,
                    format!("{rms:.4e}"),
                    format!("{crossings:.2}"),
                    seconds,
                ]
            };
            let seconds = || format!("{:.2}", amount(line, "seconds"));
            match line["kind"].as_str()? {
                "densities" => Some(row("from densities".into(), seconds())),
                "motion" => Some(row(
                    format!("run {}, {} steps", line["run"], line["steps"]),
                    seconds(),
                )),
                "together" => Some(row(
                    format!(
                        "all runs together; densities are off by {:.1} % and {:.1} %",
                        100.0 * amount(line, "rms_error"),
                        100.0 * amount(line, "zero_crossings_error")
                    ),
                    String::new(),
                )),
                _ => None,
            }
        })
        .collect();
    page + &table(&["", "rms [m]", "zero crossings [Hz]", "s"], &cells)
}
