//! The names of curves beside the axes, where they hide nothing.

use plotters::coord::Shift;
use plotters::element::{Circle, DashedPathElement, PathElement, Text};
use plotters::prelude::{Color, DrawingArea, DrawingBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::chart::{Chart, Style};
use crate::drawing::{
    DOT, FAINT_MARK, FONT, Failure, GAP, INK, LINE, MARGIN, MARK, text_style, text_width,
};
use crate::look::look;

/// The sample of a line.
const SAMPLE: i32 = 28 * DOT as i32;
/// From a name to the next.
pub(super) const LEGEND_LINE: i32 = 24 * DOT as i32;

/// Width that the legend takes beside the axes; none for a single curve.
pub(super) fn legend_width(chart: &Chart) -> u32 {
    let widths = (chart.series.iter()).map(|series| {
        let sample = match series.style {
            Style::Remark => 0,
            _ => SAMPLE as u32,
        };
        text_width(series.name.chars().count()) + sample + 2 * MARGIN
    });
    match chart.series.len() {
        0 | 1 => 0,
        _ => widths.max().unwrap_or(0),
    }
}

/// Names beside the axes, where they hide nothing.
pub(super) fn legend<B: DrawingBackend>(
    chart: &Chart,
    area: &DrawingArea<B, Shift>,
) -> Result<(), Failure<B>> {
    let style = text_style(FONT, &INK).pos(Pos::new(HPos::Left, VPos::Center));
    for (index, series) in chart.series.iter().enumerate() {
        let look = look(index, series.style);
        let height = 2 * MARGIN as i32 + LEGEND_LINE * index as i32;
        let stroke = look.colour.stroke_width(LINE);
        let ends = [(0, height), (SAMPLE, height)];
        match (series.style, look.dash) {
            (Style::Marks | Style::FaintMarks | Style::Remark, _) => {}
            (_, None) => area.draw(&PathElement::new(ends, stroke))?,
            (_, Some(dash)) => area.draw(&DashedPathElement::new(ends, dash * DOT, GAP, stroke))?,
        }
        if !series.style.is_line() {
            let radius = match series.style {
                Style::FaintMarks => FAINT_MARK,
                _ => MARK,
            };
            let sample = Circle::new((SAMPLE / 2, height), radius, look.colour.filled());
            area.draw(&sample)?;
        }
        let left = match series.style {
            Style::Remark => 0,
            _ => SAMPLE + 8 * DOT as i32,
        };
        area.draw(&Text::new(
            series.name.clone(),
            (left, height),
            style.clone(),
        ))?;
    }
    Ok(())
}
