//! `docs/data/scene_reduction.jsonl`, bounds and true errors of parts reduced for a scene, as a generated part of `docs/scene-driven.md`.

use super::{Page, raw_lines, table};

/// Bounds and true errors, in `docs/scene-driven.md`.
pub const PAGE: Page = Page {
    page: "scene-driven.md",
    data: "scene_reduction",
    markers: [
        "<!-- generated from data/scene_reduction.jsonl -->\n",
        "<!-- end of the bounds and true errors -->\n",
    ],
    render,
    pictures: |_| Vec::new(),
};

fn render(raw: &str) -> String {
    let mut last = "";
    let lines = raw_lines(raw);
    let cells: Vec<Vec<String>> = (lines.iter())
        .map(|line| {
            let part = line["part"].as_str().unwrap_or("");
            let named = if part == last { "" } else { part };
            last = part;
            let small = |key: &str| line[key].as_f64().unwrap_or(f64::NAN);
            vec![
                named.to_owned(),
                line["dofs"].to_string(),
                format!("{:.0e}", small("tolerance")),
                line["coordinates"].to_string(),
                format!("{:.1e}", small("bound")),
                format!("{:.1e}", small("true_error")),
            ]
        })
        .collect();
    table(
        &[
            "part and scene",
            "dofs",
            "tolerance",
            "coordinates",
            "bound",
            "true error",
        ],
        &cells,
    )
}
