//! `docs/data/accuracy.jsonl` as the tables of `docs/accuracy.md`.

use serde_json::Value;

use super::{Page, machine, raw_lines, rows, table, text};

/// The first generated part of `docs/accuracy.md`.
pub const PAGE: Page = Page {
    page: "accuracy.md",
    data: "accuracy",
    markers: [
        "<!-- generated from data/accuracy.jsonl -->\n",
        "<!-- end of the generated part -->\n",
    ],
    render,
    pictures: |_| Vec::new(),
};

/// Families of the dense table and the beginnings of their parts' names.
const FAMILIES: [(&str, &[&str]); 6] = [
    ("planar rods", &["planar rod, "]),
    ("spatial beams", &["spatial beam, "]),
    ("boxes", &["hexahedra, ", "tetrahedra, ", "box of "]),
    ("ring", &["symmetric ring, "]),
    ("rotor", &["rotor "]),
    ("slender box", &["slender box, "]),
];

fn render(raw: &str) -> String {
    let lines = raw_lines(raw);
    let of =
        |kind: &str| -> Vec<&Value> { lines.iter().filter(|line| line["kind"] == kind).collect() };
    let mut page = String::new();
    of("machine")
        .into_iter()
        .for_each(|line| page += &machine(line));
    page += "\n## Published rotor\n\n";
    page += &rotor(&of("published rotor"));
    page += "\n## Reference values\n\n";
    page += &reference_values(&of("reference values"));
    page += "\n## Closed forms\n\n";
    page += &closed_forms(&of("closed forms"));
    page += "\n## Unit systems\n\n";
    page += &unit_systems(&of("unit systems"));
    page += "\n## Thread counts\n\n";
    page += &table(
        &["part", "threads", "bit-identical to one thread"],
        &rows(&of("thread counts"), |line| {
            vec![
                text(line, "part"),
                line["threads"].to_string(),
                yes(&line["identical"]),
            ]
        }),
    );
    page += "\n## Dense algebra\n\n";
    page += &dense(&of("dense"));
    page
}

fn float(line: &Value, key: &str) -> f64 {
    line[key].as_f64().expect(key)
}

fn yes(value: &Value) -> String {
    if value.as_bool() == Some(true) {
        "yes"
    } else {
        "no"
    }
    .to_owned()
}

fn error(line: &Value) -> String {
    format!("{:.1e}", float(line, "relative_error"))
}

fn bound(line: &Value) -> String {
    format!("{:.0e}", float(line, "bound"))
}

/// Whole numbers as they are, others with ten digits, lists separated by commas.
fn number(value: &Value) -> String {
    match value {
        Value::Array(list) => list.iter().map(number).collect::<Vec<_>>().join(", "),
        Value::Number(whole) if whole.is_u64() => whole.to_string(),
        _ => {
            let value = value.as_f64().expect("a number");
            let before = value.abs().max(1e-300).log10().floor() as i32;
            if before < -3 {
                format!("{value:.1e}")
            } else {
                format!("{value:.*}", usize::try_from(9 - before).unwrap_or(0))
            }
        }
    }
}

/// The line closest to its bound.
fn worst<'a>(lines: impl Iterator<Item = &'a Value>) -> Option<&'a Value> {
    let share = |line: &Value| float(line, "relative_error") / float(line, "bound");
    lines.reduce(|worst, line| {
        if share(line) > share(worst) {
            line
        } else {
            worst
        }
    })
}

/// The quantities in the order in which they appear first.
fn quantities(lines: &[&Value]) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for line in lines {
        let quantity = text(line, "quantity");
        if !found.contains(&quantity) {
            found.push(quantity);
        }
    }
    found
}

fn rotor(lines: &[&Value]) -> String {
    table(
        &[
            "quantity",
            "measured",
            "reference",
            "relative error",
            "bound",
        ],
        &rows(lines, |line| {
            vec![
                text(line, "quantity"),
                number(&line["value"]),
                number(&line["reference"]),
                error(line),
                bound(line),
            ]
        }),
    )
}

fn reference_values(lines: &[&Value]) -> String {
    let cell = |file: &str, quantity: &str| {
        let here = lines
            .iter()
            .copied()
            .filter(|line| line["file"] == file && line["quantity"] == quantity);
        worst(here).map_or(String::new(), |line| {
            format!(
                "{} < {} ({}, n_k = {})",
                error(line),
                bound(line),
                text(line, "part"),
                line["n_k"]
            )
        })
    };
    let row = |quantity: String| {
        let (planar, spatial) = (
            cell("ref_planar.json", &quantity),
            cell("ref_spatial.json", &quantity),
        );
        vec![quantity, planar, spatial]
    };
    let rows: Vec<_> = quantities(lines).into_iter().map(row).collect();
    table(
        &["quantity", "planar rod of 1, 2, 4, 8, 16 elements", "boxes"],
        &rows,
    )
}

fn closed_forms(lines: &[&Value]) -> String {
    let Some(first) = lines.first() else {
        return String::new();
    };
    let list = |value: &Value| {
        value
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_f64)
            .collect::<Vec<_>>()
    };
    let elements = list(&first["elements"])
        .iter()
        .map(|n| format!("{n} elements"))
        .collect::<Vec<_>>();
    let mut header = vec!["quantity", "closed form"];
    header.extend(elements.iter().map(String::as_str));
    header.extend(["observed order", "expected"]);
    table(
        &header,
        &rows(lines, |line| {
            let mut row = vec![text(line, "quantity"), text(line, "reference")];
            row.extend(
                list(&line["relative_errors"])
                    .iter()
                    .map(|error| format!("{error:.1e}")),
            );
            let orders: Vec<String> = list(&line["orders"])
                .iter()
                .map(|order| format!("{order:.2}"))
                .collect();
            row.push(orders.join(", "));
            row.push(
                line["expected_order"]
                    .as_u64()
                    .map_or("exact".to_owned(), |order| order.to_string()),
            );
            row
        }),
    )
}

fn unit_systems(lines: &[&Value]) -> String {
    table(
        &[
            "part",
            "dofs",
            "modes",
            "largest difference of frequencies",
            "bound",
            "mode counts and ranks equal",
        ],
        &rows(lines, |line| {
            let (dofs, modes) = (line["n_e"].to_string(), line["n_k"].to_string());
            vec![
                text(line, "part"),
                dofs,
                modes,
                error(line),
                bound(line),
                yes(&line["equal"]),
            ]
        }),
    )
}

fn dense(lines: &[&Value]) -> String {
    let cell = |quantity: &str, starts: &[&str]| {
        let name = |line: &Value| {
            starts
                .iter()
                .any(|start| text(line, "part").starts_with(start))
        };
        let here = lines
            .iter()
            .copied()
            .filter(|line| line["quantity"] == quantity && name(line));
        worst(here).map_or(String::new(), |line| {
            let part = text(line, "part");
            let short = match starts {
                ["rotor " | "slender box, " | "symmetric ring, "] => String::new(),
                [start] => format!("{}, ", part.trim_start_matches(start)),
                _ => format!("{part}, "),
            };
            let (error, bound) = (error(line), bound(line));
            format!("{error} < {bound} ({short}n_k = {})", line["n_k"])
        })
    };
    let row = |quantity: String| {
        let cells = FAMILIES
            .iter()
            .map(|(_, starts)| cell(&quantity, starts))
            .collect::<Vec<_>>();
        std::iter::once(quantity).chain(cells).collect::<Vec<_>>()
    };
    let rows: Vec<_> = quantities(lines).into_iter().map(row).collect();
    let header: Vec<&str> = std::iter::once("quantity")
        .chain(FAMILIES.iter().map(|(name, _)| *name))
        .collect();
    table(&header, &rows)
}
