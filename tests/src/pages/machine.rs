//! `docs/data/machine.jsonl` as generated parts of `docs/assemblies.md` and `docs/frequency-response.md`.

use serde_json::Value;

use super::{Page, raw_lines, table};

/// The generated part of `docs/assemblies.md`.
pub const ASSEMBLY: Page = Page {
    page: "assemblies.md",
    data: "machine",
    markers: [
        "<!-- generated from data/machine.jsonl -->\n",
        "<!-- end of the generated part -->\n",
    ],
    render: assembly,
    pictures: |_| Vec::new(),
};

/// The generated part of `docs/frequency-response.md`.
pub const RESPONSES: Page = Page {
    page: "frequency-response.md",
    data: "machine",
    markers: [
        "<!-- generated from data/machine.jsonl -->\n",
        "<!-- end of the generated part -->\n",
    ],
    render: responses,
    pictures: |_| Vec::new(),
};

/// Modes whose frequencies are shown: the first, and each after so many.
const EVERY: usize = 5;

fn words(value: &Value) -> String {
    value.as_str().unwrap_or("").trim().to_owned()
}

fn amount(line: &Value, key: &str) -> f64 {
    line[key].as_f64().unwrap_or(f64::NAN)
}

fn of_kind<'a>(lines: &'a [Value], kind: &'a str) -> impl Iterator<Item = &'a Value> {
    lines.iter().filter(move |line| line["kind"] == kind)
}

fn conditions(lines: &[Value]) -> String {
    of_kind(lines, "conditions")
        .map(|line| {
            format!(
                "`{}` at commit {}, {}, {} cores: {} degrees of freedom together, {} modes.\n\n",
                words(&line["command"]),
                words(&line["commit"]),
                words(&line["machine"]["cpu"]),
                line["machine"]["cores"],
                line["dofs"],
                line["modes"]
            )
        })
        .collect()
}

fn assembly(raw: &str) -> String {
    let lines = raw_lines(raw);
    let mut page = conditions(&lines);
    let cells: Vec<Vec<String>> = of_kind(&lines, "reduction")
        .map(|line| {
            vec![
                words(&line["what"]),
                line["unknowns"].to_string(),
                format!("{:.2}", amount(line, "seconds")),
            ]
        })
        .collect();
    page += &table(&["reduced", "unknowns at a time", "s"], &cells);
    page.push('\n');
    let cells: Vec<Vec<String>> = of_kind(&lines, "frequency")
        .enumerate()
        .filter(|(index, _)| index % EVERY == 0 || *index == 1)
        .map(|(_, line)| {
            let of = |key: &str| match line[key].as_f64() {
                Some(value) => format!("{value:.1e}"),
                None => "-".into(),
            };
            vec![
                line["mode"].to_string(),
                format!("{:.3}", amount(line, "hertz")),
                of("one_level"),
                of("one_level_bound"),
                of("two_levels"),
                of("two_levels_bound"),
            ]
        })
        .collect();
    page += &table(
        &[
            "mode",
            "whole [Hz]",
            "four parts: off by",
            "told bound",
            "two levels: off by",
            "told bound",
        ],
        &cells,
    );
    page.push('\n');
    let cells: Vec<Vec<String>> = of_kind(&lines, "statics")
        .map(|line| {
            let of = |key: &str| format!("{:.1e}", amount(line, key));
            vec![
                words(&line["what"]).replace('_', " "),
                of("flexibility"),
                of("mass"),
                of("tensor"),
                of("origin"),
            ]
        })
        .collect();
    page + &table(
        &[
            "against the whole",
            "static flexibility",
            "mass",
            "inertia",
            "centre by the length",
        ],
        &cells,
    )
}

fn responses(raw: &str) -> String {
    let lines = raw_lines(raw);
    let page = conditions(&lines);
    let direct = of_kind(&lines, "direct").next();
    let accuracy = |what: &str| of_kind(&lines, "accuracy").find(|line| line["what"] == what);
    let each = direct.map(|line| amount(line, "seconds_each"));
    let mut cells: Vec<Vec<String>> = of_kind(&lines, "response")
        .map(|line| {
            let what = words(&line["what"]);
            let (count, seconds) = (amount(line, "frequencies"), amount(line, "seconds"));
            let ratio = each.map_or("not run".into(), |each| {
                format!("{:.0}", each * count / seconds)
            });
            let off = |key: &str| {
                accuracy(&what).map_or("-".into(), |of| format!("{:.1e}", amount(of, key)))
            };
            let name = match what.as_str() {
                "whole" => "superelement of the whole",
                "machine" => "assembly of four parts",
                _ => "assembly of two assemblies",
            };
            vec![
                name.into(),
                format!("{seconds:.2}"),
                ratio,
                off("median"),
                off("told_median"),
                off("largest"),
                off("told_largest"),
                accuracy(&what).map_or("-".into(), |of| {
                    format!("{:.2}", amount(of, "least_told_by_true"))
                }),
            ]
        })
        .collect();
    if let Some(direct) = direct {
        cells.push(vec![
            format!(
                "PARDISO on {} equations (from {} frequencies that it solved)",
                direct["unknowns"], direct["solved"]
            ),
            format!("{:.0}", 1000.0 * amount(direct, "seconds_each")),
            "1".into(),
            "0".into(),
            "-".into(),
            "0".into(),
            "-".into(),
            "-".into(),
        ]);
    }
    page + &table(
        &[
            "1000 frequencies",
            "s",
            "times PARDISO",
            "median error",
            "told",
            "largest error",
            "told",
            "told by true, at least",
        ],
        &cells,
    )
}
