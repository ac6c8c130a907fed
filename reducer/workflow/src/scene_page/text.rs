//! What a page says in words and tables, verdict first.

use dcb_formats::results::{Outcome, SystemModes, frequency_unit};
use dcb_report::{Cell, Column, Page, Table};
use dcb_runtime::error::Error;

use super::bodies::Drawn;
use super::moments::Moments;
use super::{Contents, Run};
use crate::plain_words::plain_words;

/// Defects of the energy balance below this part of the largest energy are good, below the next one fair.
const GOOD_BALANCE: f64 = 1e-3;
const FAIR_BALANCE: f64 = 5e-2;
/// Events that a page lists.
const MOST_EVENTS: usize = 200;

pub fn write(
    page: &mut Page,
    run: &Run,
    time: &[f64],
    moments: &Moments,
    drawn: &Drawn,
    contents: Contents,
) -> Result<(), Error> {
    let summary = run.results.provenance("summary")?;
    page.paragraph(&verdict(run, time, &summary));
    page.markup("<div id=\"view\"></div>\n");
    match moments.modes() {
        Some(found) => {
            page.paragraph("The view shows the modes one after another, each through one period and as large as can be seen: the first mode from 0 to 1 on the slider, the second from 1 to 2, and so on.");
            page.heading("Modes");
            page.table(&modes(found, run), &[]);
        }
        None => {
            page.heading("Histories");
            page.markup("<div id=\"histories\"></div>\n");
            let (frames, all) = (moments.times().len(), time.len());
            page.paragraph(&match all > frames {
                true => format!("The view has {frames} of the {all} recorded times; between them it interpolates."),
                false => format!("The view has all {frames} recorded times; between them it interpolates."),
            });
        }
    }
    page.markup("<noscript><p>The view and the curves need JavaScript.</p></noscript>\n");
    if let Some(exactness) = drawn.exactness() {
        page.paragraph(&exactness);
    }
    page.list(&drawn.notes);
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

/// Seven digits at most, none that say nothing.
fn trimmed(value: f64) -> String {
    let rounded = format!("{value:.6e}");
    rounded
        .parse::<f64>()
        .map_or(rounded, |value| value.to_string())
}

/// One sentence on each: the end, the energy, warnings.
fn verdict(run: &Run, time: &[f64], summary: &serde_json::Value) -> String {
    let unit = &run.scene.units.time;
    let last = time.last().copied().unwrap_or_default();
    let mut said = match run.results.outcome() {
        Outcome::Complete => format!("The run is complete: {} {unit}.", trimmed(last)),
        Outcome::Stopped { reason, .. } => {
            format!("The run stopped at {} {unit}: {reason}.", trimmed(last))
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

fn modes(found: &SystemModes, run: &Run) -> Table {
    let unit = frequency_unit(&run.scene.units);
    let mut table = Table {
        columns: vec![
            Column::new("mode", "mode", ""),
            Column::new("frequency", "frequency", &unit),
            Column::new("damping", "damping ratio", ""),
            Column::new("slider", "on the slider", ""),
        ],
        rows: Vec::new(),
    };
    for (index, frequency) in found.frequency.iter().enumerate() {
        table.rows.push(vec![
            Cell::Count(index as u64 + 1),
            Cell::Number(*frequency),
            Cell::maybe(found.damping_ratio.get(index).copied()),
            Cell::Text(format!("from {index} to {}", index + 1)),
        ]);
    }
    table
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
        for (what, value) in plain_words(&method) {
            add(&format!("integrator: {what}"), value);
        }
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
