//! Outputs of a study for people and programs: a table, JSON, the Pareto front as a picture, and a page with all of it.

use dcb_formats::output::Replace;
use dcb_formats::output::write_json;
use dcb_report::{Cell, Chart, Column, PARETO_FRONT, Page, Table, svg, write_svg};
use serde_json::{Value, json};

use super::pictures::{errors, front_chart, histories, shown};
use super::row::ErrorStatement;
use super::store::{Store, generator};
use super::{SceneRow, SceneStudy};
use dcb_runtime::error::Error;

/// Writes `study.csv`, `study.json`, `pareto.svg` and `report.html` into the folder of the study.
///
/// # Errors
/// [`Error::File`] where a file can't be written.
pub fn write(study: &SceneStudy, store: &Store, tolerance: f64) -> Result<(), Error> {
    table(study, Detail::Everything).write_csv(&store.path("study.csv"))?;
    write_json(&store.path("study.json"), &summary(study, tolerance))?;
    let chart = front_chart(study);
    if study.rows.iter().any(SceneRow::is_stable) {
        write_svg(
            std::slice::from_ref(&chart),
            &store.path("pareto.svg"),
            Replace::Overwrite,
        )?;
    }
    Ok(page(study, &chart, tolerance).write(&store.path("report.html"))?)
}

/// How much of the rows a table has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Detail {
    /// Criterion of a choice.
    Essential,
    /// Options, errors of every quantity, and why runs stopped.
    Errors,
    /// All of it.
    Everything,
}

/// The rows.
fn table(study: &SceneStudy, detail: Detail) -> Table {
    let time = &study.subject.scene.units.time;
    let fineness = study.subject.own.fineness;
    let mut columns = vec![
        Column::new("row", "row", ""),
        Column::new("modes", "modes", ""),
        Column::new("compatibility", "compatibility", ""),
        Column::new(fineness.name(), fineness.name(), fineness.unit(time)),
        Column::new("rho_infinity", "ρ∞", "1"),
        Column::new("inertia_change", "inertia", ""),
    ];
    let course = [
        Column::new("stable", "stable", ""),
        Column::new("elastic", "elastic coordinates", ""),
        Column::new("freedoms", "all coordinates", ""),
        Column::new("rows", "constraint and spring rows", ""),
        Column::new(
            "seconds_per_time",
            "wall time for the motion",
            &format!("s/{time}"),
        ),
        Column::new("steps_per_second", "steps per second", "1/s"),
        Column::new("error", "largest error / range", "1"),
        Column::new("error_is_bound", "error is", ""),
        Column::new("energy_defect", "energy defect / largest", "1"),
        Column::new("warnings", "warnings", ""),
    ];
    if detail != Detail::Errors {
        columns.extend(course);
    }
    if detail != Detail::Essential {
        for quantity in &study.subject.quantities {
            let of = |what: &str, unit: &str| {
                let title = format!("{} {what}", quantity.name);
                Column::new(&title, &title, unit)
            };
            columns.push(of("error max", &quantity.unit));
            columns.push(of("error rms", &quantity.unit));
            columns.push(of("error max / range", "1"));
            columns.push(of("error rms / range", "1"));
            columns.push(of("error is", ""));
        }
        columns.push(Column::new("stopped", "stopped", ""));
    }
    columns.push(Column::new("pareto_front", "on the Pareto front", ""));
    let front = study.front();
    let rows = study.rows.iter().enumerate();
    let cells = rows.map(|(index, row)| {
        let mut cells = cells(study, index, row, detail);
        let is_on_front = if front.contains(&index) { "yes" } else { "no" };
        cells.push(Cell::Text(is_on_front.to_owned()));
        cells
    });
    Table {
        columns,
        rows: cells.collect(),
    }
}

fn cells(study: &SceneStudy, index: usize, row: &SceneRow, detail: Detail) -> Vec<Cell> {
    let (setting, run) = (&row.setting, &row.course);
    let text = |text: &str| Cell::Text(text.to_owned());
    let count = |count: usize| Cell::Count(count as u64);
    let claim = row.claim(&study.reference);
    let is_bound = |is_bound: bool| text(if is_bound { "at most" } else { "measured" });
    let is_at_most = matches!(claim, ErrorStatement::AtMost(_));
    let mut cells = vec![
        count(index + 1),
        Cell::Text(setting.modes_text()),
        text(setting.compatibility.name()),
        Cell::Number(setting.fineness.value()),
        Cell::maybe(setting.rho_infinity),
        text(setting.inertia_text()),
    ];
    let course = [
        text(if row.is_stable() { "yes" } else { "no" }),
        count(run.elastic),
        count(run.freedoms),
        count(run.rows),
        Cell::maybe(row.cost(study.subject.end)),
        Cell::maybe(row.speed()),
        Cell::maybe(row.is_stable().then(|| claim.value())),
        match row.is_stable() {
            true => is_bound(is_at_most),
            false => Cell::Empty,
        },
        Cell::maybe(relative_defect(row)),
        count(run.warnings.len()),
    ];
    if detail != Detail::Errors {
        cells.extend(course);
    }
    if detail != Detail::Essential {
        for place in 0..study.subject.quantities.len() {
            match row.deviations.get(place) {
                Some(deviation) => cells.extend([
                    Cell::Number(deviation.distance.maximum),
                    Cell::Number(deviation.distance.rms),
                    Cell::maybe(deviation.relative.map(|relative| relative.maximum)),
                    Cell::maybe(deviation.relative.map(|relative| relative.rms)),
                    is_bound(deviation.is_below_reference),
                ]),
                None => cells.extend((0..5).map(|_| Cell::Empty)),
            }
        }
        cells.push(run.stopped.as_deref().map_or(Cell::Empty, text));
    }
    cells
}

fn relative_defect(row: &SceneRow) -> Option<f64> {
    let course = &row.course;
    (course.largest_energy > 0.0).then(|| course.energy_defect / course.largest_energy)
}

/// All of it for programs.
fn summary(study: &SceneStudy, tolerance: f64) -> Value {
    let subject = &study.subject;
    let front = study.front();
    let rows = study.rows.iter().enumerate().map(|(index, row)| {
        json!({
            "row": index + 1,
            "options": row.setting.in_scene(subject),
            "modes": row.setting.modes_text(),
            "stable": row.is_stable(),
            "seconds_per_time": row.cost(subject.end),
            "steps_per_second": row.speed(),
            "error": row.is_stable().then(|| row.claim(&study.reference).value()),
            "error_measured": row.is_stable().then(|| row.error()),
            "pareto_front": front.contains(&index),
            "course": row.course,
            "timing": row.timing,
            "outputs": row.deviations,
        })
    });
    let quantities = subject.quantities.iter().zip(&study.reference.convergence);
    let quantities = quantities.map(|(quantity, convergence)| {
        json!({"name": quantity.name, "unit": quantity.unit, "range": convergence.scale,
            "reference_error": convergence.uncertainty, "reference_order": convergence.order})
    });
    let files = subject.files.iter();
    let files =
        files.map(|file| json!({"file": file.path.display().to_string(), "digest": file.digest}));
    let best = study.best(tolerance);
    json!({
        "generator": generator(),
        "scene": subject.scene,
        "superelements": files.collect::<Vec<_>>(),
        "outputs": quantities.collect::<Vec<_>>(),
        "times": {"spacing": study.grid.spacing, "count": study.grid.count},
        "reference": {
            "options": study.reference.setting.in_scene(subject),
            "steps": study.reference.steps,
            "error": study.reference.uncertainty(),
            "converged": study.reference.is_converged(),
        },
        "rows": rows.collect::<Vec<_>>(),
        "front": front.iter().map(|index| index + 1).collect::<Vec<_>>(),
        "best": {
            "tolerance": tolerance,
            "row": best.map(|index| index + 1),
            "options": best.map(|index| study.rows[index].setting.in_scene(subject)),
        },
    })
}

fn page(study: &SceneStudy, chart: &Chart, tolerance: f64) -> Page {
    let mut page = Page::new("Study of a scene");
    page.heading("Which variant to take");
    page.paragraph(&study.verdict(tolerance));
    let decades = study.decades();
    if !decades.is_empty() {
        page.paragraph(&format!(
            "The fastest row for each error, relative to the output's range; {} is the scene's {}:",
            study.subject.own.fineness.symbol(),
            study.subject.own.fineness.name()
        ));
        page.list(&decades);
    }
    page.heading("Error against time");
    page.paragraph(&format!(
        "{PARETO_FRONT} Point at a mark to see which variant it is."
    ));
    if let Ok(picture) = svg(std::slice::from_ref(chart)) {
        page.picture(
            &picture,
            &format!(
                "Each mark is a row; {} is the scene's {}. The error is the largest of all outputs over all times, relative \
                 to the output's range.",
                study.subject.own.fineness.symbol(),
                study.subject.own.fineness.told(&study.subject.scene.units.time)
            ),
        );
    }
    let shown = shown(study, tolerance);
    if !shown.is_empty() {
        page.heading("Histories");
        page.paragraph(&format!(
            "{} of {} rows, evenly chosen from the Pareto front, and the reference. All rows are in the tables below and in study.csv, their \
             histories in histories/*.h5. Columns that stay zero are left out.",
            shown.len(),
            study.rows.len()
        ));
        let told = shown
            .iter()
            .map(|index| study.told(*index, &study.rows[*index]));
        page.list(&told.collect::<Vec<_>>());
        page.pictures(&histories(study, &shown));
        page.heading("Errors over time");
        page.paragraph(
            "The same runs: the largest error up to each time, relative to the range. What is smaller than the error of the reference is drawn at that; \
             outputs whose errors stay below 1e-9 are left out.",
        );
        page.pictures(&errors(study, &shown));
    }
    tables(study, &mut page);
    page.heading("How it was measured");
    page.list(&study.conditions());
    page
}

/// What comes after the pictures: rows, warnings, the reference.
fn tables(study: &SceneStudy, page: &mut Page) {
    let (front, count) = (study.front(), study.rows.len());
    page.heading("All rows");
    page.folded_table(
        &format!("Options, time and error of {count} rows; the Pareto front stands out"),
        &table(study, Detail::Essential),
        &front,
    );
    page.folded_table(
        &format!("Errors of every output of {count} rows"),
        &table(study, Detail::Errors),
        &front,
    );
    for (index, row) in study.rows.iter().enumerate() {
        if let Some(reason) = &row.course.stopped {
            page.paragraph(&format!(
                "Row {} didn't come to its end: {reason}",
                index + 1
            ));
        }
    }
    let warned: Vec<String> = warnings(study);
    if !warned.is_empty() {
        page.heading("Warnings");
        page.list(&warned);
    }
    page.heading("Reference");
    page.paragraph(&study.reference_told());
    page.folded_table(
        "How well converged each output of the reference is",
        &convergence(study),
        &[],
    );
}

fn convergence(study: &SceneStudy) -> Table {
    let told = study
        .subject
        .quantities
        .iter()
        .zip(&study.reference.convergence);
    Table {
        columns: vec![
            Column::new("output", "output", ""),
            Column::new("unit", "unit", ""),
            Column::new("range", "range", ""),
            Column::new("error", "estimated error of the reference / range", "1"),
            Column::new("order", "order seen", ""),
        ],
        rows: told
            .map(|(quantity, convergence)| {
                vec![
                    Cell::Text(quantity.name.clone()),
                    Cell::Text(quantity.unit.clone()),
                    Cell::maybe(convergence.scale),
                    Cell::Number(convergence.relative()),
                    Cell::maybe(convergence.order),
                ]
            })
            .collect(),
    }
}

/// Each warning once, with the rows that have it.
fn warnings(study: &SceneStudy) -> Vec<String> {
    let mut told: Vec<(&str, Vec<String>)> = Vec::new();
    for (index, row) in study.rows.iter().enumerate() {
        for warning in &row.course.warnings {
            let number = (index + 1).to_string();
            match told.iter_mut().find(|(known, _)| known == warning) {
                Some((_, rows)) => rows.push(number),
                None => told.push((warning.as_str(), vec![number])),
            }
        }
    }
    let lines = told.into_iter();
    lines
        .map(|(warning, rows)| format!("{warning} (rows {})", rows.join(", ")))
        .collect()
}
