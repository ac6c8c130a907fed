//! What a page says in words and tables, verdict first.

use dcb_formats::results::Outcome;
use dcb_report::{Cell, Column, Page, Table};
use dcb_runtime::error::Error;

use super::{Contents, Run};

/// Defects of the energy balance below this part of the largest energy are good, below the next one fair.
const GOOD_BALANCE: f64 = 1e-3;
const FAIR_BALANCE: f64 = 5e-2;
/// Events that a page lists.
const MOST_EVENTS: usize = 200;

pub fn write(
    page: &mut Page,
    run: &Run,
    time: &[f64],
    frames: usize,
    notes: &[String],
    contents: Contents,
) -> Result<(), Error> {
    let summary = run.results.provenance("summary")?;
    page.paragraph(&verdict(run, time, &summary));
    page.markup("<div id=\"view\"></div>\n");
    page.heading("Histories");
    page.markup("<div id=\"histories\"></div>\n<noscript><p>The view and the curves need JavaScript.</p></noscript>\n");
    let picture = match time.len() > frames {
        true => format!(
            "The view has {frames} of the {} recorded times; between them it interpolates.",
            time.len()
        ),
        false => format!("The view has all {frames} recorded times; between them it interpolates."),
    };
    page.paragraph(&picture);
    page.list(notes);
    let events = run.results.events()?;
    if !events.is_empty() {
        page.heading("What the run noted");
        let lines = events.iter().take(MOST_EVENTS);
        let unit = &run.scene.units.time;
        let lines = lines.map(|event| format!("t = {:.6} {unit}: {}", event.time, event.message));
        page.list(&lines.collect::<Vec<_>>());
    }
    if contents == Contents::Motion {
        return Ok(());
    }
    page.heading("Bodies");
    page.table(&bodies(run), &[]);
    page.heading("The run");
    page.table(&facts(run, time, &summary), &[]);
    page.heading("Files that it read");
    page.table(&files(run), &[]);
    Ok(())
}

/// One sentence on each: the end, the energy, warnings.
fn verdict(run: &Run, time: &[f64], summary: &serde_json::Value) -> String {
    let unit = &run.scene.units.time;
    let last = time.last().copied().unwrap_or_default();
    let mut said = match run.results.outcome() {
        Outcome::Complete => format!("The run is complete: {last:.6} {unit}."),
        Outcome::Stopped { reason, .. } => {
            format!("The run stopped at {last:.6} {unit}: {reason}.")
        }
    };
    let defect = summary["energy_defect"].as_f64();
    let largest = summary["largest_energy"].as_f64();
    if let (Some(defect), Some(largest)) = (defect, largest.filter(|largest| *largest > 0.0)) {
        let part = defect.abs() / largest;
        let word = match part {
            part if part <= GOOD_BALANCE => "Its energy balance is good",
            part if part <= FAIR_BALANCE => {
                "Its energy balance is fair; a smaller step makes it better"
            }
            _ => "Its energy balance is poor: use a smaller step",
        };
        said += &format!(" {word}: the largest defect is {part:.1e} of the largest energy.");
    }
    said
}

fn columns(names: &[&str]) -> Vec<Column> {
    names
        .iter()
        .map(|name| Column::new(name, name, ""))
        .collect()
}

fn bodies(run: &Run) -> Table {
    let mut table = Table {
        columns: columns(&["body", "is", "elastic coordinates", "interfaces or points"]),
        rows: Vec::new(),
    };
    for body in &run.model.system.bodies {
        let kind = match run.file_name_of(&body.name) {
            none if none.is_empty() => "rigid".to_owned(),
            file => file,
        };
        let names = body.flexible.interfaces.iter();
        let names: Vec<&str> = names.map(|interface| interface.name.as_str()).collect();
        table.rows.push(vec![
            Cell::Text(body.name.clone()),
            Cell::Text(kind),
            Cell::Count(body.flexible.coordinate_count() as u64),
            Cell::Text(names.join(", ")),
        ]);
    }
    table
}

fn facts(run: &Run, time: &[f64], summary: &serde_json::Value) -> Table {
    let mut table = Table {
        columns: columns(&["what", "value"]),
        rows: Vec::new(),
    };
    let mut add = |what: &str, value: String| {
        table
            .rows
            .push(vec![Cell::Text(what.to_owned()), Cell::Text(value)])
    };
    add("recorded times", time.len().to_string());
    let number = |key: &str| summary[key].as_f64();
    for (key, what) in [
        ("steps", "steps"),
        ("newton_iterations", "Newton iterations"),
        ("jacobian_updates", "factorizations"),
        ("elastic_coordinates", "elastic coordinates"),
    ] {
        if let Some(value) = number(key) {
            add(what, format!("{value}"));
        }
    }
    if let Some(seconds) = number("integration_seconds") {
        add("time of the integration", format!("{seconds:.3} s"));
    }
    if let Some(method) = run
        .scene
        .integrator
        .and_then(|one| serde_json::to_value(one).ok())
    {
        add("integrator", method.to_string());
    }
    table
}

fn files(run: &Run) -> Table {
    let mut table = Table {
        columns: columns(&["file", "SHA-256"]),
        rows: Vec::new(),
    };
    for file in &run.model.files {
        let name = file.path.file_name().unwrap_or_default().to_string_lossy();
        table.rows.push(vec![
            Cell::Text(name.into_owned()),
            Cell::Text(file.digest.clone()),
        ]);
    }
    table
}
