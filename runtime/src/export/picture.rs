//! Pictures of results as SVG: histories of a simulation over time. The charts themselves are
//! [`dcb_report`]'s, for documents as well.

use std::path::Path;

use dcb_formats::output::Replace;
use dcb_formats::results::Results;
pub use dcb_report::{Axis, Chart, Note, ReferenceSlope, Scale, Series, Style, svg, write_svg};

use crate::error::Error;
use crate::export::history::{Quantity, Selection, histories};

/// What stays below this part of its channel is rounding.
const ROUNDING: f64 = 1e-13;

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
    let mut scales: Vec<f64> = Vec::new();
    for history in listed.columns {
        let points = over.values.iter().zip(&history.values);
        let series = Series {
            name: history.name.clone(),
            points: points.map(|(over, value)| [*over, *value]).collect(),
            style,
        };
        let kind = (history.unit, history.quantity);
        match charts.iter().position(|(known, _)| *known == kind) {
            Some(place) => {
                charts[place].1.series.push(series);
                scales[place] = scales[place].max(history.scale);
            }
            None => {
                scales.push(history.scale);
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
    for (((unit, quantity), mut chart), scale) in charts.into_iter().zip(scales) {
        let unit = unit.replace('*', "·");
        chart.vertical.label = match (chart.series.as_slice(), quantity.name()) {
            ([only], _) => format!("{} [{unit}]", only.name),
            (_, Some(name)) => format!("{name} [{unit}]"),
            _ => format!("[{unit}]"),
        };
        let points = chart.series.iter_mut().flat_map(|one| &mut one.points);
        let points: Vec<&mut [f64; 2]> = points.collect();
        let largest = points
            .iter()
            .fold(0.0_f64, |most, point| most.max(point[1].abs()));
        if largest > 0.0 && largest <= ROUNDING * scale {
            chart.vertical.label += ", zero to rounding";
            points.into_iter().for_each(|point| point[1] = 0.0);
        }
        finished.push(chart);
    }
    Ok(write_svg(&finished, path, replace)?)
}
