//! `docs/data/speed_against_error.jsonl` as the generated part of `docs/speed-against-error.md`, and as its pictures.

use dcb_report::{Axis, Candidate, Chart, Series, Style, pareto_front};
use serde_json::Value;

use super::{Page, Picture, raw_lines, table};

/// The generated part of `docs/speed-against-error.md`, and its pictures.
pub const PAGE: Page = Page {
    page: "speed-against-error.md",
    data: "speed_against_error",
    markers: [
        "<!-- generated from data/speed_against_error.jsonl -->\n",
        "<!-- end of the generated part -->\n",
    ],
    render,
    pictures,
};
/// Errors for which the fastest run of each family is shown.
const WANTED: [f64; 4] = [1e-1, 1e-2, 1e-3, 1e-4];

/// Runs that belong together: tool, compatibility, and columns beside the modes.
type Family = (String, String, String);

struct Run<'a> {
    line: &'a Value,
    family: Family,
}

impl Run<'_> {
    fn number(&self, key: &str) -> f64 {
        self.line[key].as_f64().unwrap_or(f64::NAN)
    }

    fn candidate(&self) -> Candidate {
        Candidate {
            label: String::new(),
            cost: self.number("seconds_per_time"),
            error: self.number("error"),
        }
    }
}

fn text(line: &Value, key: &str) -> String {
    line[key].as_str().unwrap_or("").to_owned()
}

/// Problems in the order of the lines, each with the line of its reference and its runs.
fn problems(lines: &[Value]) -> Vec<(&Value, Vec<Run<'_>>)> {
    let references = lines.iter().filter(|line| line["kind"] == "reference");
    references
        .map(|reference| {
            let own = lines
                .iter()
                .filter(|line| line["kind"] == "run" && line["problem"] == reference["problem"]);
            let runs = own.map(|line| Run {
                line,
                family: (
                    text(line, "tool"),
                    text(line, "compatibility"),
                    text(line, "enrich"),
                ),
            });
            (reference, runs.collect())
        })
        .collect()
}

fn families(runs: &[Run<'_>]) -> Vec<Family> {
    let mut found: Vec<Family> = Vec::new();
    for run in runs {
        if !found.contains(&run.family) {
            found.push(run.family.clone());
        }
    }
    found
}

fn called((tool, compatibility, enrich): &Family) -> String {
    match (tool.as_str(), enrich.as_str()) {
        ("exudyn", _) => "Exudyn".to_owned(),
        (_, "") => compatibility.clone(),
        (_, enrich) => format!("{compatibility}, `--enrich {enrich}`"),
    }
}

fn render(raw: &str) -> String {
    let lines = raw_lines(raw);
    let mut page = String::new();
    for line in lines.iter().filter(|line| line["kind"] == "conditions") {
        let machine = &line["machine"];
        page += &format!(
            "`{}` at commit {}, {}, {} cores, Python {}; ρ∞ = {}.\n",
            text(line, "command"),
            text(line, "commit"),
            text(machine, "cpu"),
            machine["cores"],
            text(machine, "python"),
            line["rho_infinity"],
        );
    }
    let version = lines.iter().find_map(|line| line["version"].as_str());
    if let Some(version) = version {
        page += &format!("Exudyn {version}.\n");
    }
    for (reference, runs) in problems(&lines) {
        let name = text(reference, "problem");
        page += &format!(
            "\n## {name}\n\n![error against time](pictures/speed-{name}.svg)\n\nReference: {} modes, steps of {:.2e} s; with twice the step it differs by {:.1e}. Simulated: {} s.\n\n",
            reference["modes"],
            reference["step"].as_f64().unwrap_or(f64::NAN),
            reference["uncertainty"].as_f64().unwrap_or(f64::NAN),
            reference["end"],
        );
        page += &fastest(&runs);
        let has_peer = runs.iter().any(|run| run.family.0 == "exudyn");
        if !has_peer {
            page += "\nExudyn: not run.\n";
        }
    }
    page + &window(&lines) + &reductions(&lines)
}

/// Form or tool of a line about reductions.
fn reduced_by(line: &Value) -> String {
    match text(line, "tool").as_str() {
        "scipy" => "SciPy, the basis of `strong`".to_owned(),
        _ => text(line, "variant"),
    }
}

/// The reduction itself, beside SciPy.
fn reductions(lines: &[Value]) -> String {
    let own = lines.iter().filter(|line| line["kind"] == "reduction");
    let rows: Vec<Vec<String>> = own
        .map(|line| {
            let short = |key: &str| {
                line[key]
                    .as_f64()
                    .map_or("–".to_owned(), |value| format!("{value:.1e}"))
            };
            vec![
                reduced_by(line),
                format!("{}", line["modes"]),
                format!("{:.3}", line["seconds"].as_f64().unwrap_or(f64::NAN)),
                short("error"),
                short("flexibility_difference"),
                short("frequency_difference"),
            ]
        })
        .collect();
    let header = [
        "form",
        "modes",
        "reduction [s]",
        "response error",
        "F_res, ours against theirs",
        "frequencies, ours against theirs",
    ];
    format!(
        "\n## reduction\n\n![error against time](pictures/speed-reduction.svg)\n\nThe connecting rod of steel, one thread, without reading: `reduce study`'s time of a whole reduction with invariants, certificate and file, and SciPy's of modes and attachments alone \
         (`tests/benches/scipy_reduction.py`). The response error is that of [study.md](study.md), the larger of collocated and transfer.\n\n{}",
        table(&header, &rows)
    )
}

/// The three forms inside the window of the paper's own.
fn window(lines: &[Value]) -> String {
    let own = lines.iter().filter(|line| line["kind"] == "window");
    let rows: Vec<Vec<String>> = own
        .map(|line| {
            let number = |key: &str| line[key].as_f64().unwrap_or(f64::NAN);
            vec![
                text(line, "compatibility"),
                format!("{}", line["modes"]),
                format!("{}", line["coordinates"]),
                format!("{}", line["steps_per_revolution"]),
                format!("{:.1e}", number("error")),
                format!("{:.1e}", number("mean_error")),
            ]
        })
        .collect();
    let header = [
        "form",
        "modes",
        "coordinates",
        "steps a revolution",
        "error",
        "r.m.s. error",
    ];
    format!(
        "\n## Inside the window of the paper's form\n\nThe slider-crank with 4 elements at steps so long that `weak` is stable with 5 modes; errors against all modes at the same steps, so that the steps' own error isn't in them. \
         Coordinates are those of a Newton iteration's body: modes, and attachments or interface forces.\n\n{}",
        table(&header, &rows)
    )
}

/// The fastest run of each family for some errors.
fn fastest(runs: &[Run<'_>]) -> String {
    let mut rows = Vec::new();
    for family in families(runs) {
        for wanted in WANTED {
            let within = runs
                .iter()
                .filter(|run| run.family == family && run.number("error") <= wanted);
            let best = within.min_by(|a, b| {
                let cost = |run: &Run<'_>| run.number("seconds_per_time");
                cost(a).total_cmp(&cost(b))
            });
            let mut row = vec![called(&family), format!("{wanted:.0e}")];
            row.extend(match best {
                Some(run) => [
                    format!("{}", run.line["modes"]),
                    format!("{}", run.line["coordinates"]),
                    format!("{:.2e}", run.number("step")),
                    format!("{:.3}", run.number("seconds_per_time")),
                    format!("{:.1e}", run.number("error")),
                    format!("{:.1e}", run.number("mean_error")),
                ],
                None => [(); 6].map(|()| "–".to_owned()),
            });
            rows.push(row);
        }
    }
    table(
        &[
            "form",
            "error wanted",
            "modes",
            "coordinates",
            "step [s]",
            "s per simulated s",
            "error",
            "r.m.s. error",
        ],
        &rows,
    )
}

/// Names of the pictures and their charts: the runs of each family that no other of it beats, and all others as marks.
fn pictures(raw: &str) -> Vec<Picture> {
    let lines = raw_lines(raw);
    let of_reductions = reduction_chart(&lines);
    problems(&lines)
        .into_iter()
        .map(|(reference, runs)| {
            let name = text(reference, "problem");
            let series = families(&runs).into_iter().map(|family| {
                let own: Vec<Candidate> = runs
                    .iter()
                    .filter(|run| run.family == family)
                    .map(Run::candidate)
                    .collect();
                let front = pareto_front(&own);
                Series {
                    name: called(&family).replace('`', ""),
                    points: front
                        .into_iter()
                        .map(|index| [own[index].cost, own[index].error])
                        .collect(),
                    style: Style::LineAndMarks,
                }
            });
            let chart = Chart {
                title: name.clone(),
                horizontal: Axis::logarithmic("time for a simulated second [s]"),
                vertical: Axis::logarithmic("largest error / largest deflection"),
                series: series.collect(),
                slopes: Vec::new(),
                notes: Vec::new(),
            };
            (format!("speed-{name}.svg"), vec![chart])
        })
        .chain([("speed-reduction.svg".to_owned(), vec![of_reductions])])
        .collect()
}

fn reduction_chart(lines: &[Value]) -> Chart {
    let mut series: Vec<Series> = Vec::new();
    for line in lines.iter().filter(|line| line["kind"] == "reduction") {
        let name = reduced_by(line).replace('`', "");
        let number = |key: &str| line[key].as_f64().unwrap_or(f64::NAN);
        let point = [number("seconds"), number("error")];
        match series.iter_mut().find(|series| series.name == name) {
            Some(series) => series.points.push(point),
            None => series.push(Series {
                name,
                points: vec![point],
                style: Style::LineAndMarks,
            }),
        }
    }
    Chart {
        title: "reduction".into(),
        horizontal: Axis::logarithmic("time of the reduction [s]"),
        vertical: Axis::logarithmic("error of the response"),
        series,
        slopes: Vec::new(),
        notes: Vec::new(),
    }
}
