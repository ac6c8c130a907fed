//! `docs/data/weak_form_map.jsonl` as two generated parts of `docs/stability.md`, and as its picture.

use dcb_report::{Axis, Chart, Series, Style};

use super::{Page, machine, raw_lines, table};
use crate::hard::dynamics::step_rules;
use crate::hard::dynamics::weak_form_map::{Cell, cells};

/// The map, and its picture.
pub const PAGE: Page = Page {
    page: "stability.md",
    data: "weak_form_map",
    markers: [
        "<!-- generated from data/weak_form_map.jsonl -->\n",
        "<!-- end of the generated map -->\n",
    ],
    render,
    pictures: |raw| vec![("weak-form-map.svg".to_owned(), vec![chart(raw)])],
};

/// The measured rules.
pub const RULES: Page = Page {
    page: "stability.md",
    data: "weak_form_map",
    markers: [
        "<!-- rules from data/weak_form_map.jsonl -->\n",
        "<!-- end of the generated rules -->\n",
    ],
    render: |raw| step_rules::render(&raw_lines(raw)),
    pictures: |_| Vec::new(),
};

fn render(raw: &str) -> String {
    let lines = raw_lines(raw);
    let cells = cells(raw);
    let mut page = String::new();
    for line in lines.iter().filter(|line| line["kind"] == "machine") {
        page += &machine(line);
    }
    let wrong = cells
        .iter()
        .filter(|cell| cell.is_allowed() != cell.is_stable());
    let unsafe_ones = cells
        .iter()
        .filter(|cell| cell.is_allowed() && !cell.is_stable());
    let ratios: Vec<String> = wrong
        .clone()
        .map(|cell| format!("{:.2}", cell.ratio))
        .collect();
    page += &format!(
        "\n{} cells; the criterion says what happens in all but {}, of which {} are unstable where it says stable.{}\n",
        cells.len(),
        wrong.count(),
        unsafe_ones.count(),
        if ratios.is_empty() {
            String::new()
        } else {
            format!(
                " The others survive at {} of the smallest step.",
                ratios.join(", ")
            )
        }
    );
    page += "\nσ_min by modes, against the first frequency that the modes leave out:\n\n";
    let growth: Vec<Vec<String>> = lines
        .iter()
        .filter(|line| line["kind"] == "growth")
        .map(|line| {
            let number = |key: &str| {
                line[key]
                    .as_f64()
                    .map_or("-".to_owned(), |value| format!("{value:.0}"))
            };
            vec![
                line["modes"].to_string(),
                line["negative_eigenvalues"].to_string(),
                number("sigma_min"),
                number("first_omitted"),
            ]
        })
        .collect();
    page += &table(
        &[
            "modes",
            "negative eigenvalues",
            "σ_min [1/s]",
            "first left out [rad/s]",
        ],
        &growth,
    );
    for group in groups(&cells, |cell| cell.radius) {
        page += &format!(
            "\n**ρ = {}**: steps survived, `all` of those asked for; bold where the criterion allows the step.\n\n",
            group[0].radius
        );
        page += &survival_table(&group);
    }
    page + "\n![steps survived over the step by the smallest stable one](pictures/weak-form-map.svg)\n"
}

/// Cells with the same value of something, in the order of their appearance.
fn groups(cells: &[Cell], of: impl Fn(&Cell) -> f64) -> Vec<Vec<Cell>> {
    let mut groups: Vec<Vec<Cell>> = Vec::new();
    for cell in cells {
        match groups.iter_mut().find(|group| of(&group[0]) == of(cell)) {
            Some(group) => group.push(*cell),
            None => groups.push(vec![*cell]),
        }
    }
    groups
}

fn survival_table(cells: &[Cell]) -> String {
    let columns = groups(cells, |cell| cell.steps as f64);
    let mut titles = vec!["modes".to_owned()];
    titles.extend(columns.iter().map(|column| column[0].steps.to_string()));
    let titles: Vec<&str> = titles.iter().map(String::as_str).collect();
    let rows: Vec<Vec<String>> = groups(cells, |cell| cell.modes as f64)
        .iter()
        .map(|row| {
            let shown = row.iter().map(|cell| {
                let survived = if cell.is_stable() {
                    "all".to_owned()
                } else {
                    cell.survived.to_string()
                };
                if cell.is_allowed() {
                    format!("**{survived}**")
                } else {
                    survived
                }
            });
            std::iter::once(row[0].modes.to_string())
                .chain(shown)
                .collect()
        })
        .collect();
    table(&titles, &rows)
}

/// Every cell in which something grows: steps survived over the step by the smallest stable one.
fn chart(raw: &str) -> Chart {
    let cells = cells(raw);
    let series = groups(&cells, |cell| cell.radius)
        .into_iter()
        .map(|group| Series {
            name: format!("ρ = {}", group[0].radius),
            points: group
                .iter()
                .filter(|cell| cell.ratio.is_finite())
                .map(|cell| [cell.ratio, cell.survived.max(1) as f64])
                .collect(),
            style: Style::Marks,
        })
        .collect();
    Chart {
        title: String::new(),
        horizontal: Axis::logarithmic("h σ_min (1 - ρ) / (2 √3 (1 + ρ))"),
        vertical: Axis::logarithmic("steps survived"),
        series,
        slopes: Vec::new(),
        notes: Vec::new(),
    }
}
