//! What a study leaves for people and programs: a table, JSON, the Pareto front as a picture, and a page with all of it.

use dcb_formats::report::{
    Axis, Cell, Chart, Column, Family, Note, Page, Series, Style, Table, pareto_chart,
    pareto_front, svg, write_json, write_svg,
};
use serde_json::{Value, json};

use super::comparison::places;
use super::grid::Trace;
use super::row::Claim;
use super::setting::Setting;
use super::store::{Store, generator};
use super::{Row, Study};
use crate::error::Error;

/// Runs whose histories the page shows, the reference not among them.
const MOST_HISTORIES: usize = 3;

/// Writes `study.csv`, `study.json`, `pareto.svg` and `report.html` into the folder of the study.
///
/// # Errors
/// [`Error::File`] where a file can't be written.
pub fn write(study: &Study, store: &Store, tolerance: f64) -> Result<(), Error> {
    table(study, Detail::Everything).write_csv(&store.path("study.csv"))?;
    write_json(&store.path("study.json"), &summary(study, tolerance))?;
    let chart = front_chart(study);
    if study.rows.iter().any(Row::is_stable) {
        write_svg(std::slice::from_ref(&chart), &store.path("pareto.svg"))?;
    }
    Ok(page(study, &chart, tolerance).write(&store.path("report.html"))?)
}

/// How much of the rows a table has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Detail {
    /// What a choice is made by.
    Essential,
    /// Errors of every quantity, and why runs stopped.
    Everything,
}

/// Error against cost: rows of different steps are joined.
fn front_chart(study: &Study) -> Chart {
    let mut families: Vec<Family> = Vec::new();
    let mut order: Vec<usize> = (0..study.rows.len()).collect();
    order.sort_by(|a, b| {
        let step = |index: &usize| study.rows[*index].setting.step;
        step(a).total_cmp(&step(b))
    });
    let names: Vec<String> = study
        .rows
        .iter()
        .map(|row| family(study, &row.setting))
        .collect();
    // Families in the order of the rows, their members in that of the steps.
    for name in &names {
        if families.iter().all(|family| family.name != *name) {
            families.push(Family {
                name: name.clone(),
                candidates: Vec::new(),
            });
        }
    }
    let candidates = study.candidates();
    for index in order {
        let candidate = &candidates[index];
        let family = families
            .iter_mut()
            .find(|family| family.name == names[index]);
        if let Some(family) = family
            && candidate.cost.is_finite()
            && candidate.error.is_finite()
        {
            family.candidates.push(candidate.clone());
        }
    }
    families.retain(|family| !family.candidates.is_empty());
    let time = &study.subject.scene.units.time;
    let mut chart = pareto_chart(
        "",
        &format!("wall time for 1 {time} of motion [s]"),
        "largest error / range [1]",
        &families,
    );
    // Words at every mark would hide each other.
    let told = pareto_front(&candidates).into_iter();
    chart.notes = told
        .map(|index| Note {
            text: candidates[index].label.clone(),
            at: [candidates[index].cost, candidates[index].error],
        })
        .collect();
    let costs: Vec<f64> = (candidates.iter().map(|candidate| candidate.cost))
        .filter(|cost| cost.is_finite())
        .collect();
    let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
    let most = costs.iter().copied().fold(0.0, f64::max);
    let limit = study.reference.uncertainty();
    if limit > 0.0 && least < most {
        chart.series.push(Series {
            name: "reference ±".to_owned(),
            points: vec![[least, limit], [most, limit]],
            style: Style::Line,
        });
    }
    chart
}

/// What rows that differ in their step alone have in common, as far as the study varies it.
fn family(study: &Study, setting: &Setting) -> String {
    let mut parts = Vec::new();
    let varies = |of: fn(&Setting) -> String| {
        let mut all = study.rows.iter().map(|row| of(&row.setting));
        let first = all.next();
        all.any(|other| Some(other) != first)
    };
    if study.subject.most_modes().is_some() {
        parts.push(setting.modes_told());
        parts.push(setting.compatibility_text().to_owned());
    }
    if varies(|setting| setting.inertia_text().to_owned()) {
        parts.push(setting.inertia_text().to_owned());
    }
    if varies(|setting| format!("{:?}", setting.rho_infinity)) {
        parts.push(format!("ρ {}", setting.rho_infinity.unwrap_or(f64::NAN)));
    }
    match parts.is_empty() {
        true => "rows".to_owned(),
        false => parts.join(", "),
    }
}

/// The rows.
fn table(study: &Study, detail: Detail) -> Table {
    let time = &study.subject.scene.units.time;
    let mut columns = vec![
        Column::new("row", "row", ""),
        Column::new("modes", "modes", ""),
        Column::new("compatibility", "compatibility", ""),
        Column::new("step", "step", time),
        Column::new("rho_infinity", "ρ∞", "1"),
        Column::new("inertia_change", "inertia", ""),
        Column::new("stable", "stable", ""),
        Column::new("elastic", "elastic coordinates", ""),
        Column::new("freedoms", "all coordinates", ""),
        Column::new("rows", "constraint and spring rows", ""),
        Column::new(
            "seconds_per_time",
            "wall time for the motion",
            &format!("s/{time}"),
        ),
        Column::new("steps_per_second", "steps in a second", "1/s"),
        Column::new("error", "largest error / range", "1"),
        Column::new("error_is_bound", "error is", ""),
        Column::new("energy_defect", "energy defect / largest", "1"),
        Column::new("warnings", "warnings", ""),
    ];
    if detail == Detail::Everything {
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
    let rows = study.rows.iter().enumerate();
    Table {
        columns,
        rows: rows
            .map(|(index, row)| cells(study, index, row, detail))
            .collect(),
    }
}

fn cells(study: &Study, index: usize, row: &Row, detail: Detail) -> Vec<Cell> {
    let (setting, course) = (&row.setting, &row.course);
    let text = |text: &str| Cell::Text(text.to_owned());
    let count = |count: usize| Cell::Count(count as u64);
    let claim = row.claim(&study.reference);
    let is_bound = |is_bound: bool| text(if is_bound { "at most" } else { "measured" });
    let is_at_most = matches!(claim, Claim::AtMost(_));
    let mut cells = vec![
        count(index + 1),
        Cell::Text(setting.modes_text()),
        text(setting.compatibility_text()),
        Cell::Number(setting.step),
        Cell::maybe(setting.rho_infinity),
        text(setting.inertia_text()),
        text(if row.is_stable() { "yes" } else { "no" }),
        count(course.elastic),
        count(course.freedoms),
        count(course.rows),
        Cell::maybe(row.cost(study.subject.end)),
        Cell::maybe(row.speed()),
        Cell::maybe(row.is_stable().then(|| claim.value())),
        match row.is_stable() {
            true => is_bound(is_at_most),
            false => Cell::Empty,
        },
        Cell::maybe(relative_defect(row)),
        count(course.warnings.len()),
    ];
    if detail == Detail::Everything {
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
        cells.push(course.stopped.as_deref().map_or(Cell::Empty, text));
    }
    cells
}

fn relative_defect(row: &Row) -> Option<f64> {
    let course = &row.course;
    (course.largest_energy > 0.0).then(|| course.energy_defect / course.largest_energy)
}

/// All of it for programs.
fn summary(study: &Study, tolerance: f64) -> Value {
    let subject = &study.subject;
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
        "front": study.front().iter().map(|index| index + 1).collect::<Vec<_>>(),
        "best": {
            "tolerance": tolerance,
            "row": best.map(|index| index + 1),
            "options": best.map(|index| study.rows[index].setting.in_scene(subject)),
        },
    })
}

fn page(study: &Study, chart: &Chart, tolerance: f64) -> Page {
    let mut page = Page::new("Study of a scene");
    page.paragraph(&study.verdict(tolerance));
    page.heading("Error against time");
    if let Ok(picture) = svg(std::slice::from_ref(chart)) {
        page.picture(
            &picture,
            "Each mark is a row; rows of one colour differ in the step alone, which is told for those that no other beats, as a \
             multiple of the scene's. \
             The error is the largest of all outputs over all times, relative to the output's range.",
        );
    }
    page.paragraph("The fastest row for each error:");
    page.table(&decades(study), &[]);
    page.heading("Rows");
    let front = study.front();
    page.table(&table(study, Detail::Essential), &front);
    page.paragraph("Rows that no other beats in both time and error stand out.");
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
    page.heading("Histories");
    let shown = shown(study, tolerance);
    page.pictures(&histories(study, &shown));
    page.paragraph(
        "Errors of the same runs, relative to the range; what is smaller than the reference is known is drawn at that:",
    );
    page.pictures(&errors(study, &shown));
    page.heading("Reference");
    page.paragraph(&study.reference_told());
    page.table(&convergence(study), &[]);
    page.heading("Errors of every output");
    page.table(&table(study, Detail::Everything), &front);
    page.heading("How it was measured");
    page.list(&study.conditions());
    page
}

/// The fastest row for errors of 0.1, 0.01 and so on, down to what the reference can tell.
fn decades(study: &Study) -> Table {
    let time = &study.subject.scene.units.time;
    let rows = (1..12)
        .map(|power| 10.0_f64.powi(-power))
        .map_while(|tolerance| study.best(tolerance).map(|index| (tolerance, index)));
    Table {
        columns: vec![
            Column::new("tolerance", "error up to", "1"),
            Column::new("row", "row", ""),
            Column::new("options", "options", ""),
            Column::new(
                "seconds_per_time",
                "wall time for the motion",
                &format!("s/{time}"),
            ),
        ],
        rows: rows
            .map(|(tolerance, index)| {
                let row = &study.rows[index];
                vec![
                    Cell::Number(tolerance),
                    Cell::Count(index as u64 + 1),
                    Cell::Text(row.setting.told(time)),
                    Cell::maybe(row.cost(study.subject.end)),
                ]
            })
            .collect(),
    }
}

fn convergence(study: &Study) -> Table {
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
fn warnings(study: &Study) -> Vec<String> {
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

/// Rows whose histories are shown: the best one, the fastest, and that of the scene's own options, each once.
fn shown(study: &Study, tolerance: f64) -> Vec<usize> {
    let own = study
        .rows
        .iter()
        .position(|row| row.setting == study.subject.own);
    let fastest = study.front().first().copied();
    let mut shown = Vec::new();
    for index in [study.best(tolerance), fastest, own].into_iter().flatten() {
        if !shown.contains(&index) && study.rows[index].is_stable() {
            shown.push(index);
        }
    }
    shown.truncate(MOST_HISTORIES);
    shown
}

/// One picture for each column of each quantity.
fn histories(study: &Study, shown: &[usize]) -> Vec<(String, String)> {
    let mut pictures = Vec::new();
    let columns = places(&study.subject.quantities);
    for (quantity, columns) in study.subject.quantities.iter().zip(columns) {
        for (label, column) in quantity.labels.iter().zip(columns) {
            let series = |name: &str, trace: &Trace| Series {
                name: name.to_owned(),
                points: points(study, trace, |row| row[column]),
                style: Style::Line,
            };
            let mut all: Vec<Series> = (shown.iter())
                .map(|index| series(&format!("row {}", index + 1), &study.traces[*index]))
                .collect();
            all.push(series("reference", &study.reference_trace));
            let name = match label.as_str() {
                "" => quantity.name.clone(),
                label => format!("{}.{label}", quantity.name),
            };
            let axis = Axis::linear(&format!("{name} [{}]", quantity.unit));
            pictures.extend(drawn(study, &name, axis, all));
        }
    }
    pictures
}

/// The error of each quantity over time.
fn errors(study: &Study, shown: &[usize]) -> Vec<(String, String)> {
    let mut pictures = Vec::new();
    let columns = places(&study.subject.quantities);
    let quantities = study.subject.quantities.iter().zip(columns);
    for ((quantity, columns), known) in quantities.zip(&study.reference.convergence) {
        let Some(scale) = known.scale else {
            continue;
        };
        let series = shown.iter().map(|shown| {
            let trace = &study.traces[*shown];
            let distance = |(index, row): (usize, &[f64])| {
                let reference = study.reference_trace.row(index)?;
                let pairs = row[columns.clone()].iter().zip(&reference[columns.clone()]);
                let square: f64 = pairs.map(|(a, b)| (a - b).powi(2)).sum();
                Some([
                    study.grid.time(index),
                    (square.sqrt() / scale).max(known.relative()),
                ])
            };
            let rows = (0..trace.len()).filter_map(|index| Some((index, trace.row(index)?)));
            Series {
                name: format!("row {}", shown + 1),
                points: rows.filter_map(distance).collect(),
                style: Style::Line,
            }
        });
        let axis = Axis::logarithmic(&format!("error of {} / range [1]", quantity.name));
        pictures.extend(drawn(study, &quantity.name, axis, series.collect()));
    }
    pictures
}

fn points(study: &Study, trace: &Trace, value: impl Fn(&[f64]) -> f64) -> Vec<[f64; 2]> {
    let rows = (0..trace.len()).filter_map(|index| Some((index, trace.row(index)?)));
    rows.map(|(index, row)| [study.grid.time(index), value(row)])
        .collect()
}

/// A picture over time, and its caption; nothing where there is nothing to draw.
fn drawn(
    study: &Study,
    caption: &str,
    vertical: Axis,
    series: Vec<Series>,
) -> Option<(String, String)> {
    let chart = Chart {
        title: String::new(),
        horizontal: Axis::linear(&format!("time [{}]", study.subject.scene.units.time)),
        vertical,
        series,
        slopes: Vec::new(),
        notes: Vec::new(),
    };
    let picture = svg(&[chart]).ok()?;
    Some((picture, caption.to_owned()))
}
