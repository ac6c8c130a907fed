//! `docs/data/scene_driven.jsonl` as the generated part of `docs/scene-driven.md`.

use serde_json::Value;

use crate::accuracy_page::table;

/// The generated part stands between these lines.
pub const MARKERS: [&str; 2] = [
    "<!-- generated from data/scene_driven.jsonl -->\n",
    "<!-- end of the generated part -->\n",
];

fn number(line: &Value, key: &str) -> f64 {
    line[key].as_f64().unwrap_or(f64::NAN)
}

fn text<'a>(line: &'a Value, key: &str) -> &'a str {
    line[key].as_str().unwrap_or("")
}

/// Everything between the markers.
pub fn render(raw: &str) -> String {
    let lines: Vec<Value> = (raw.lines())
        .map(|line| serde_json::from_str(line).expect("a line of JSON"))
        .collect();
    let mut page = String::new();
    for line in lines.iter().filter(|line| line["kind"] == "conditions") {
        let machine = &line["machine"];
        page += &format!(
            "`{}` at commit {}, {}, {} cores; ρ∞ = {}.\n",
            text(line, "command").trim(),
            text(line, "commit"),
            text(machine, "cpu"),
            machine["cores"],
            line["rho_infinity"],
        );
    }
    let rows: Vec<&Value> = lines.iter().filter(|line| line["kind"] == "row").collect();
    let mut scenes: Vec<&str> = rows.iter().map(|row| text(row, "scene")).collect();
    scenes.dedup();
    for scene in scenes {
        let own: Vec<&Value> = (rows.iter().copied())
            .filter(|row| text(row, "scene") == scene)
            .collect();
        page += &format!("\n#### {scene}\n\n{}", scene_table(&own));
    }
    page
}

fn scene_table(rows: &[&Value]) -> String {
    let fixed = rows.iter().find(|row| text(row, "row").ends_with(" modes"));
    let fixed = fixed.map_or(f64::NAN, |row| number(row, "seconds_per_second"));
    let cells: Vec<Vec<String>> = (rows.iter())
        .map(|row| {
            let tolerance = row["tolerance"].as_f64();
            vec![
                text(row, "row").to_owned(),
                tolerance.map_or("–".to_owned(), |tolerance| format!("{tolerance:.0e}")),
                row["coordinates"].to_string(),
                format!("{:.2e}", number(row, "used_step")),
                format!("{:.0}", number(row, "file_bytes") / 1024.0),
                format!("{:.2}", number(row, "preparation_seconds")),
                format!("{:.3}", number(row, "seconds_per_second")),
                format!("{:.2}", fixed / number(row, "seconds_per_second")),
                format!("{:.1e}", number(row, "error")),
            ]
        })
        .collect();
    table(
        &[
            "model",
            "tolerance",
            "coordinates",
            "step [s]",
            "files [KiB]",
            "made in [s]",
            "s per simulated s",
            "times as fast as 20 modes",
            "error",
        ],
        &cells,
    )
}
