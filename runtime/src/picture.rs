//! Pictures of results as SVG: histories of a simulation over time. The charts themselves are
//! [`dcb_formats::report`]'s, for documents as well.

use std::path::Path;

pub use dcb_formats::report::{
    Axis, Chart, Note, ReferenceSlope, Scale, Series, Style, svg, write_svg,
};
use dcb_formats::results::Results;

use crate::error::Error;
use crate::history::{History, Selection, histories};

/// Draws the selected channels over time: those of one unit in one chart, the charts below each other. An existing
/// file is replaced.
///
/// # Errors
/// [`Error::File`] if a channel isn't there or can't be read, if none is selected, or if the file can't be written.
pub fn plot(results: &Results, selection: Selection, path: &Path) -> Result<(), Error> {
    let time = results.time()?;
    let mut charts: Vec<(String, Chart)> = Vec::new();
    for history in histories(results, selection)? {
        let series = over_time(&time, &history);
        match charts.iter_mut().find(|(unit, _)| *unit == history.unit) {
            Some((_, chart)) => chart.series.push(series),
            None => {
                let chart = Chart {
                    title: String::new(),
                    horizontal: Axis::linear(&format!("time [{}]", results.units().time)),
                    vertical: Axis::linear(""),
                    series: vec![series],
                    slopes: Vec::new(),
                    notes: Vec::new(),
                };
                charts.push((history.unit, chart));
            }
        }
    }
    let mut finished = Vec::new();
    for (unit, mut chart) in charts {
        chart.vertical.label = match chart.series.as_slice() {
            [only] => format!("{} [{unit}]", only.name),
            _ => format!("[{unit}]"),
        };
        finished.push(chart);
    }
    Ok(write_svg(&finished, path)?)
}

fn over_time(time: &[f64], history: &History) -> Series {
    let points = time.iter().zip(&history.values);
    Series {
        name: history.name.clone(),
        points: points.map(|(time, value)| [*time, *value]).collect(),
        style: Style::Line,
    }
}
