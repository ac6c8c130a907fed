//! Pictures of curves as SVG: histories of a simulation, and line charts for documents.
//!
//! A [`Chart`] is plain data; [`write_svg`] draws one or several below each other. [`plot`] makes the charts of a
//! results file. Text is left to the viewer's sans-serif font, so that nothing depends on the fonts of the machine
//! that draws. Values that aren't finite, or beyond
//! 1e300, or not positive on a logarithmic axis, interrupt their line.

mod axis;
mod curve;
mod draw;

use std::path::Path;

use dcb_formats::results::Results;

use crate::error::Error;
use crate::history::{History, Selection, histories};
pub use draw::write_svg;

/// One set of axes and what is drawn in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Heading; empty for none.
    pub title: String,
    /// Abscissa.
    pub horizontal: Axis,
    /// Ordinate.
    pub vertical: Axis,
    /// Curves in the order of the legend.
    pub series: Vec<Series>,
    /// Slopes to compare with.
    pub slopes: Vec<ReferenceSlope>,
}

/// What an axis shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// Quantity and unit, for example `time [s]`.
    pub label: String,
    /// Linear or logarithmic.
    pub scale: Scale,
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            scale: Scale::Linear,
        }
    }

    /// A logarithmic axis.
    pub fn logarithmic(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            scale: Scale::Logarithmic,
        }
    }
}

/// How values become places on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal steps are equally long.
    Linear,
    /// Equal ratios are equally long.
    Logarithmic,
}

/// One curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Points (x, y) in the order in which they are joined.
    pub points: Vec<[f64; 2]>,
    /// Line, marks or both.
    pub style: Style,
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A line through the points.
    Line,
    /// A mark at each point.
    Marks,
    /// Both.
    LineAndMarks,
}

/// A thin dashed line `y = c xᵖ` through a point: on logarithmic axes, a slope.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceSlope {
    /// What stands at its end, for example `h²`.
    pub name: String,
    /// p.
    pub exponent: f64,
    /// A point of the line, both coordinates positive.
    pub through: [f64; 2],
}

/// Draws the selected channels over time: those of one unit in one chart, the charts below each other. An existing
/// file is replaced.
///
/// # Errors
/// [`Error::File`] if a channel isn't there or can't be read; [`Error::NothingToShow`] if none is selected;
/// [`Error::CannotWrite`].
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
    write_svg(&finished, path)
}

fn over_time(time: &[f64], history: &History) -> Series {
    let points = time.iter().zip(&history.values);
    Series {
        name: history.name.clone(),
        points: points.map(|(time, value)| [*time, *value]).collect(),
        style: Style::Line,
    }
}
