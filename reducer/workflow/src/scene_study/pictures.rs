//! The pictures of a study: error against time, and histories of chosen rows with their errors.

use dcb_report::{Axis, Chart, Series, Style, pareto_chart, small_svg, thinned};

use super::SceneStudy;
use super::comparison::places;
use super::grid::Trace;

/// Runs whose histories the page shows, the reference not among them: more can't be told apart.
const MOST_HISTORIES: usize = 6;
/// A column that stays below this part of its quantity's range is zero up to rounding: nothing to look at.
const NOTHING: f64 = 1e-10;
/// Errors below this part of the range are rounding, of driven motions for example.
const ROUNDING: f64 = 1e-9;

/// Error against cost, the Pareto front named.
pub(super) fn front_chart(study: &SceneStudy) -> Chart {
    let candidates = study.candidates();
    let rows = study.rows.iter().enumerate();
    let told: Vec<String> = rows.map(|(index, row)| study.told(index, row)).collect();
    let time = &study.subject.scene.units.time;
    let mut chart = pareto_chart(
        "",
        &format!("wall time for 1 {time} of motion [s]"),
        "largest error / range [1]",
        &candidates,
        &told,
    );
    let costs: Vec<f64> = (candidates.iter().map(|candidate| candidate.cost))
        .filter(|cost| cost.is_finite())
        .collect();
    let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
    let most = costs.iter().copied().fold(0.0, f64::max);
    let limit = study.reference.uncertainty();
    if limit > 0.0 && least < most {
        chart.series.push(Series {
            name: "error of the reference".to_owned(),
            points: vec![[least, limit], [most, limit]],
            style: Style::NamedLine,
        });
    }
    chart
}

/// Rows whose histories are shown: the Pareto front, evenly thinned, the best one among them.
pub(super) fn shown(study: &SceneStudy, tolerance: f64) -> Vec<usize> {
    thinned(&study.front(), MOST_HISTORIES, study.best(tolerance))
}

/// The last words of a legend: how many rows have no curve.
fn left_out(study: &SceneStudy, shown: &[usize]) -> Vec<Series> {
    let count = study.rows.len() - shown.len();
    let remark = |name: String| Series {
        name,
        points: Vec::new(),
        style: Style::Remark,
    };
    match count {
        0 => Vec::new(),
        1 => vec![remark("1 row left out".to_owned())],
        _ => vec![remark(format!("{count} rows left out"))],
    }
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
                style: Style::NamedLine,
            };
            let mut all: Vec<Series> = (shown.iter())
                .map(|index| series(&format!("row {}", index + 1), &study.traces[*index]))
                .collect();
            all.push(series("reference", &study.reference_trace));
            all.extend(left_out(study, shown));
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

/// The largest error of each quantity up to every time: errors themselves pass through zero all the time. Without quantities whose errors
/// are rounding.
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
                Some((index, square.sqrt() / scale))
            };
            let rows = (0..trace.len()).filter_map(|index| Some((index, trace.row(index)?)));
            let largest = rows
                .filter_map(distance)
                .scan(known.relative(), |largest, next| {
                    *largest = largest.max(next.1);
                    Some([study.grid.time(next.0), *largest])
                });
            Series {
                name: format!("row {}", shown + 1),
                points: largest.collect(),
                style: Style::NamedLine,
            }
        });
        let series: Vec<Series> = series.collect();
        let last = series.iter().filter_map(|series| series.points.last());
        if last.map(|point| point[1]).fold(0.0, f64::max) < ROUNDING {
            continue;
        }
        let series = series.into_iter().chain(left_out(study, shown));
        let axis = Axis::logarithmic("largest error / range [1]");
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
