//! The pictures of a study: error against time, and histories of chosen rows with their errors.

use dcb_report::{
    Axis, Candidate, Chart, Family, Note, Series, Style, pareto_chart, pareto_front, small_svg,
};

use super::SceneStudy;
use super::comparison::places;
use super::grid::Trace;
use super::setting::Setting;

/// Runs whose histories the page shows, the reference not among them.
const MOST_HISTORIES: usize = 3;
/// A column that stays below this part of its quantity's range is zero up to rounding: nothing to look at.
const NOTHING: f64 = 1e-10;

/// Error against cost: rows of different steps are joined.
pub(super) fn front_chart(study: &SceneStudy) -> Chart {
    let rows = study.rows.iter();
    let names: Vec<String> = rows.map(|row| family(study, &row.setting)).collect();
    let candidates = study.candidates();
    let is_drawn = |index: &usize| {
        let Candidate { cost, error, .. } = candidates[*index];
        cost.is_finite() && error.is_finite()
    };
    let mut order: Vec<usize> = (0..names.len()).filter(is_drawn).collect();
    // Families in the order of the rows, their members in that of the steps.
    order.sort_by(|a, b| {
        let first = |index: &usize| names.iter().position(|name| *name == names[*index]);
        let step = |index: &usize| study.rows[*index].setting.step;
        (first(a).cmp(&first(b))).then(step(a).total_cmp(&step(b)))
    });
    let named = order.into_iter();
    let families = Family::of(named.map(|index| (names[index].clone(), candidates[index].clone())));
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

/// Common properties of rows that differ in their step alone, as far as the study varies it.
fn family(study: &SceneStudy, setting: &Setting) -> String {
    let mut parts = Vec::new();
    let varies = |of: fn(&Setting) -> String| {
        let mut all = study.rows.iter().map(|row| of(&row.setting));
        let first = all.next();
        all.any(|other| Some(other) != first)
    };
    if study.subject.most_modes().is_some() {
        parts.push(setting.modes_told());
        parts.push(setting.compatibility.name().to_owned());
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

/// Rows whose histories are shown: the best one, the fastest, and that of the scene's own options, each once.
pub(super) fn shown(study: &SceneStudy, tolerance: f64) -> Vec<usize> {
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

/// One picture for each column of each quantity that isn't zero.
pub(super) fn histories(study: &SceneStudy, shown: &[usize]) -> Vec<(String, String)> {
    let mut pictures = Vec::new();
    let columns = places(&study.subject.quantities);
    let quantities = study.subject.quantities.iter().zip(columns);
    for ((quantity, columns), known) in quantities.zip(&study.reference.convergence) {
        let least = known.scale.map_or(0.0, |scale| NOTHING * scale);
        for (label, column) in quantity.labels.iter().zip(columns) {
            let traces = shown.iter().map(|index| &study.traces[*index]);
            let mut rows = traces
                .chain([&study.reference_trace])
                .flat_map(|trace| (0..trace.len()).filter_map(|index| trace.row(index)));
            if rows.all(|row| row[column].abs() <= least) {
                continue;
            }
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
pub(super) fn errors(study: &SceneStudy, shown: &[usize]) -> Vec<(String, String)> {
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

fn points(study: &SceneStudy, trace: &Trace, value: impl Fn(&[f64]) -> f64) -> Vec<[f64; 2]> {
    let rows = (0..trace.len()).filter_map(|index| Some((index, trace.row(index)?)));
    rows.map(|(index, row)| [study.grid.time(index), value(row)])
        .collect()
}

/// A picture over time, and its caption; nothing where there is nothing to draw.
fn drawn(
    study: &SceneStudy,
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
    let picture = small_svg(&chart).ok()?;
    Some((picture, caption.to_owned()))
}
