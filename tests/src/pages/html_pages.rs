//! `docs/data/pages.jsonl` as a generated part of `docs/pages.md`.

use super::{Page, raw_lines, table, text};

/// Size and speed of pages, and what an accessibility checker finds.
pub const PAGE: Page = Page {
    page: "pages.md",
    data: "pages",
    markers: [
        "<!-- generated from data/pages.jsonl -->\n",
        "<!-- end of what is generated from data/pages.jsonl -->\n",
    ],
    render,
    pictures: |_| Vec::new(),
};

fn render(raw: &str) -> String {
    let lines = raw_lines(raw);
    let rows: Vec<Vec<String>> = (lines.iter())
        .map(|line| {
            let number = |key: &str| line[key].as_f64().expect(key);
            let count = |key: &str| line[key].as_array().expect(key).len();
            vec![
                text(line, "what"),
                format!("{:.2}", number("bytes") / 1e6),
                format!("{:.0}", number("fps")),
                format!("{:.0}", number("cpuMsPerPicture")),
                text(line, "resolution"),
                count("violations").to_string(),
                count("errors").to_string(),
            ]
        })
        .collect();
    let first = &lines[0];
    let conditions = format!(
        "`{}`, commit {}, {}, {} cores, {}, headless, without a graphics card.\n\n",
        text(first, "command"),
        text(first, "commit"),
        text(&first["machine"], "cpu"),
        first["machine"]["cores"],
        text(first, "browser"),
    );
    conditions
        + &table(
            &[
                "page",
                "size, MB",
                "pictures a second",
                "processor time of a picture, ms",
                "view, pixels",
                "findings of axe",
                "errors on the console",
            ],
            &rows,
        )
}
