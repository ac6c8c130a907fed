//! `docs/data/scene_driven.jsonl` as the generated part of `docs/scene-driven.md`.

use serde_json::Value;

use super::{Page, raw_lines, table};

/// What was measured of prepared scenes, in `docs/scene-driven.md`.
pub const PAGE: Page = Page {
    page: "scene-driven.md",
    data: "scene_driven",
    markers: [
        "<!-- generated from data/scene_driven.jsonl -->\n",
        "<!-- end of the generated part -->\n",
    ],
    render,
    pictures: |_| Vec::new(),
};

fn number(line: &Value, key: &str) -> f64 {
    line[key].as_f64().unwrap_or(f64::NAN)
}

fn text<'a>(line: &'a Value, key: &str) -> &'a str {
    line[key].as_str().unwrap_or("")
}

fn render(raw: &str) -> String {
    let lines = raw_lines(raw);
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
    let rows = rows(&lines);
    let mut scenes: Vec<&str> = rows.iter().map(|row| text(row.prepared, "scene")).collect();
    scenes.dedup();
    for scene in scenes {
        let of_scene = |row: &&Row| text(row.prepared, "scene") == scene;
        let mut own: Vec<&Row> = rows.iter().filter(of_scene).collect();
        own.sort_by_key(|row| row.tolerance().is_some());
        page += &format!("\n#### {scene}\n\n{}", scene_table(&own));
    }
    page
}

/// What was prepared and run in one way, runs of all rounds.
pub struct Row<'a> {
    /// The line of its preparation.
    pub prepared: &'a Value,
    /// Those of its runs.
    pub runs: Vec<&'a Value>,
}

impl Row<'_> {
    /// What the scene was prepared for, if it was.
    pub fn tolerance(&self) -> Option<f64> {
        self.prepared["tolerance"].as_f64()
    }

    /// The largest of all runs.
    pub fn error(&self) -> f64 {
        let errors = self.runs.iter().map(|run| number(run, "error"));
        errors.fold(0.0, f64::max)
    }

    /// The least of all runs.
    pub fn seconds_per_second(&self) -> f64 {
        let seconds = self
            .runs
            .iter()
            .map(|run| number(run, "seconds_per_second"));
        seconds.fold(f64::INFINITY, f64::min)
    }
}

/// Every row that was run.
pub fn rows(lines: &[Value]) -> Vec<Row<'_>> {
    let same = |a: &Value, b: &Value| {
        ["scene", "row", "tolerance"]
            .iter()
            .all(|key| a[*key] == b[*key])
    };
    let of_kind = |kind: &'static str| lines.iter().filter(move |line| line["kind"] == kind);
    of_kind("preparation")
        .map(|prepared| Row {
            prepared,
            runs: of_kind("run").filter(|run| same(run, prepared)).collect(),
        })
        .filter(|row| !row.runs.is_empty())
        .collect()
}

fn scene_table(rows: &[&Row]) -> String {
    let fixed = (rows.iter()).find(|row| text(row.prepared, "row").ends_with(" modes"));
    let fixed = fixed.map_or(f64::NAN, |row| row.seconds_per_second());
    let cells: Vec<Vec<String>> = (rows.iter())
        .map(|row| {
            let run = row.runs[0];
            vec![
                text(row.prepared, "row").to_owned(),
                row.tolerance()
                    .map_or("–".to_owned(), |tolerance| format!("{tolerance:.0e}")),
                run["coordinates"].to_string(),
                text(run, "integrator").to_owned(),
                format!("{:.2e}", number(run, "used_step")),
                format!("{:.0}", number(row.prepared, "file_bytes") / 1024.0),
                format!("{:.2}", number(row.prepared, "preparation_seconds")),
                format!("{:.3}", row.seconds_per_second()),
                format!("{:.2}", fixed / row.seconds_per_second()),
                format!("{:.1e}", row.error()),
            ]
        })
        .collect();
    table(
        &[
            "model",
            "tolerance",
            "coordinates",
            "integrator",
            "mean step [s]",
            "files [KiB]",
            "made in [s]",
            "s per simulated s",
            "times as fast as 20 modes",
            "error",
        ],
        &cells,
    )
}
