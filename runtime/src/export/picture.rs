//! Pictures of results as SVG: histories of a simulation over time. The charts themselves are
//! [`dcb_report`]'s, for documents as well.

use std::path::Path;

use dcb_formats::output::Replace;
use dcb_formats::results::Results;
pub use dcb_report::{Axis, Chart, Note, ReferenceSlope, Scale, Series, Style, svg, write_svg};

use crate::error::Error;
use crate::export::history::{Quantity, Selection, histories};

/// Draws the selected channels over time: those of one unit and quantity in one chart, the charts below each other. The file is
/// written whole or not at all.
///
/// # Errors
/// [`Error::File`] if a channel isn't there or can't be read, if none is selected, if the file is there and may not be replaced, or if it
/// can't be written.
pub fn plot(
    results: &Results,
    selection: Selection,
    path: &Path,
    replace: Replace,
) -> Result<(), Error> {
    let listed = histories(results, selection)?;
    let over = &listed.over;
    let style = match listed.is_motion {
        true => Style::Line,
        false => Style::Marks,
    };
    let mut charts: Vec<((String, Quantity), Chart)> = Vec::new();
    for history in listed.columns {
        let points = over.values.iter().zip(&history.values);
        let series = Series {
            name: history.name.clone(),
            points: points.map(|(over, value)| [*over, *value]).collect(),
            style,
        };
        let kind = (history.unit, history.quantity);
        match charts.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, chart)) => chart.series.push(series),
            None => {
                let chart = Chart {
                    title: String::new(),
                    horizontal: Axis::linear(&format!("{} [{}]", over.name, over.unit)),
                    vertical: Axis::linear(""),
                    series: vec![series],
                    slopes: Vec::new(),
                    notes: Vec::new(),
                };
                charts.push((kind, chart));
            }
        }
    }
    let mut finished = Vec::new();
    for ((unit, quantity), mut chart) in charts {
        chart.vertical.label = match chart.series.as_slice() {
            [only] => format!("{} [{unit}]", only.name),
            _ if quantity == Quantity::Energy => format!("energy [{unit}]"),
            _ => format!("[{unit}]"),
        };
        finished.push(chart);
    }
    Ok(write_svg(&finished, path, replace)?)
}
