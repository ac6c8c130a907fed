//! Charts to SVG.

use std::io::Write as _;
use std::path::Path;

use plotters::chart::ChartContext;
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::element::{Circle, DashedPathElement, PathElement, Text};
use plotters::prelude::{
    Color, DrawingArea, DrawingBackend, IntoDrawingArea, RGBColor, SVGBackend, WHITE,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::axis::{Ends, Ruler};
use crate::chart::{Chart, ReferenceSlope, Scale, Series, Style};
use crate::curve::pieces;
use crate::drawing::{
    CHARACTER, DOT, FAINT_MARK, FONT, Failure, GAP, INK, LINE, MARGIN, MARK, text_style, text_width,
};
use crate::hover::Hover;
use crate::label_places::{Mark, Word, placed};
use crate::legend::{LEGEND_LINE, legend, legend_width};
use crate::look::{Look, look};
use dcb_formats::Error;
use dcb_formats::output::{Replace, write_stream};

const GRID: RGBColor = RGBColor(222, 222, 222);
const REFERENCE: RGBColor = RGBColor(120, 120, 120);

/// Sizes in steps of the drawing; a picture is scaled to where it is shown.
const WIDTH: u32 = 960 * DOT;
const HEIGHT: u32 = 400 * DOT;
const SMALL_WIDTH: u32 = 560 * DOT;
const SMALL_HEIGHT: u32 = 320 * DOT;
/// Words at points, by the font of everything else.
const SMALLER: f64 = 0.8;
const THIN: u32 = DOT;
const TICK: u32 = 5 * DOT;

type Plane<'a, B> = ChartContext<'a, B, Cartesian2d<Ruler, Ruler>>;

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotDrawn {
    /// No chart, or no point in all of them.
    #[error("there are no values to draw")]
    Empty,
    /// The plotting library refused.
    #[error("the picture can't be drawn: {0}")]
    Refused(String),
}

/// Charts below each other as the text of one SVG picture.
///
/// # Errors
/// [`NotDrawn`].
pub fn svg(charts: &[Chart]) -> Result<String, NotDrawn> {
    let longest = charts.iter().map(|chart| chart.series.len()).max();
    let legend = LEGEND_LINE as u32 * (longest.unwrap_or(0) as u32 + 3);
    sized(charts, [WIDTH, HEIGHT.max(legend)], [8, 6])
}

/// A chart for pages where several stand side by side: smaller, so that its words are as large as theirs.
///
/// # Errors
/// [`NotDrawn`].
pub fn small_svg(chart: &Chart) -> Result<String, NotDrawn> {
    let size = [SMALL_WIDTH, SMALL_HEIGHT];
    sized(std::slice::from_ref(chart), size, [5, 5])
}

/// Charts of this size each, with about so many ticks along and up.
fn sized(charts: &[Chart], size: [u32; 2], ticks: [usize; 2]) -> Result<String, NotDrawn> {
    let is_empty = |chart: &Chart| chart.series.iter().all(|series| series.points.is_empty());
    if charts.iter().all(is_empty) {
        return Err(NotDrawn::Empty);
    }
    let [width, height] = [size[0], size[1] * charts.len() as u32];
    let mut svg = String::new();
    let hover = draw(charts, (width, height), ticks, &mut svg).map_err(NotDrawn::Refused)?;
    let drawing = format!("width=\"{width}\" height=\"{height}\"");
    let shown = format!("width=\"{}\" height=\"{}\"", width / DOT, height / DOT);
    Ok(hover.over(svg.replacen(&drawing, &shown, 1)))
}

/// Writes charts below each other into one SVG file, whole or not at all.
///
/// # Errors
/// [`Error::File`] if nothing can be drawn, or if the file is there and may not be replaced; [`Error::NoRoom`] on a full disk; [`Error::Io`].
pub fn write_svg(charts: &[Chart], path: &Path, replace: Replace) -> Result<(), Error> {
    let text = svg(charts).map_err(|why| Error::File {
        path: path.to_owned(),
        message: why.to_string(),
    })?;
    write_stream(path, replace, |out| out.write_all(text.as_bytes()))
}

fn draw(
    charts: &[Chart],
    size: (u32, u32),
    ticks: [usize; 2],
    svg: &mut String,
) -> Result<Hover, String> {
    let root = SVGBackend::with_string(svg, size).into_drawing_area();
    let told = |error: &dyn std::fmt::Display| error.to_string();
    root.fill(&WHITE).map_err(|error| told(&error))?;
    let rulers: Vec<(Ruler, Ruler)> = (charts.iter()).map(|chart| rulers(chart, ticks)).collect();
    let label_lengths = rulers.iter().map(|(_, y)| y.label_length());
    let widths = Widths {
        labels: text_width(label_lengths.max().unwrap_or(0)),
        legend: charts.iter().map(legend_width).max().unwrap_or(0),
    };
    let areas = root.split_evenly((charts.len(), 1));
    let mut hover = Hover::default();
    for ((chart, rulers), area) in charts.iter().zip(rulers).zip(areas) {
        panel(chart, rulers, widths, &area, &mut hover).map_err(|error| told(&error))?;
    }
    root.present().map_err(|error| told(&error))?;
    Ok(hover)
}

/// Room left and right of the axes, the same for all charts of a picture: their axes are aligned.
#[derive(Clone, Copy)]
struct Widths {
    labels: u32,
    legend: u32,
}

fn rulers(chart: &Chart, ticks: [usize; 2]) -> (Ruler, Ruler) {
    let values = |index: usize| {
        let points = chart.series.iter().flat_map(|series| &series.points);
        points.map(move |point| point[index])
    };
    let is_history = chart.series.iter().all(|series| series.style.is_line());
    let ends = if is_history { Ends::Tight } else { Ends::Loose };
    let x = Ruler::around(values(0), chart.horizontal.scale, ends, ticks[0]);
    let y = Ruler::around(values(1), chart.vertical.scale, Ends::Loose, ticks[1]);
    (x, y)
}

fn panel<B: DrawingBackend>(
    chart: &Chart,
    (x, y): (Ruler, Ruler),
    widths: Widths,
    area: &DrawingArea<B, Shift>,
    hover: &mut Hover,
) -> Result<(), Failure<B>> {
    let plane_width = area.dim_in_pixel().0.saturating_sub(widths.legend);
    let (plane_area, legend_area) = area.split_horizontally(plane_width as i32);
    let title = if chart.title.is_empty() {
        0
    } else {
        (2.0 * FONT) as u32
    };
    // The last label of the abscissa stands half beside the axes.
    let beside = text_width(x.label_length()) / 2;
    let mut builder = plotters::chart::ChartBuilder::on(&plane_area);
    builder
        .margin_top(MARGIN)
        .margin_bottom(MARGIN)
        .margin_left(MARGIN)
        .margin_right(MARGIN.max(beside))
        .x_label_area_size((3.0 * FONT) as u32)
        .y_label_area_size(widths.labels + (2.5 * FONT) as u32);
    if title > 0 {
        builder.caption(&chart.title, text_style(1.1 * FONT, &INK));
    }
    let mut plane = builder.build_cartesian_2d(x.clone(), y.clone())?;
    plane
        .configure_mesh()
        .bold_line_style(GRID.stroke_width(THIN))
        .light_line_style(WHITE)
        .axis_style(INK.stroke_width(THIN))
        .set_all_tick_mark_size(TICK)
        .label_style(text_style(FONT, &INK))
        .axis_desc_style(text_style(FONT, &INK))
        .x_desc(chart.horizontal.label.as_str())
        .y_desc(chart.vertical.label.as_str())
        .draw()?;
    for slope in &chart.slopes {
        reference(&mut plane, slope, &x, &y)?;
    }
    for (index, series) in chart.series.iter().enumerate() {
        curve(
            series,
            look(index, series.style),
            &mut plane,
            (&x, &y),
            hover,
        )?;
    }
    words(chart, &mut plane, &x, &y)?;
    let place = |[right, high]: [f64; 2]| {
        let is_shown = x.contains(right) && y.contains(high);
        is_shown.then(|| plane.backend_coord(&(right, high)))
    };
    for note in chart.notes.iter().filter(|note| !note.told.is_empty()) {
        if let Some(at) = place(note.at) {
            hover.mark(at, MARK, &note.told);
        }
    }
    if chart.series.len() > 1 {
        legend(chart, &legend_area)?;
    }
    Ok(())
}

/// The marks and lines of one series.
fn curve<B: DrawingBackend>(
    series: &Series,
    look: Look,
    plane: &mut Plane<B>,
    (x, y): (&Ruler, &Ruler),
    hover: &mut Hover,
) -> Result<(), Failure<B>> {
    for piece in pieces(&series.points, x, y) {
        let points = || piece.iter().map(|point| (point[0], point[1]));
        let is_dot = series.style.is_line() && piece.len() == 1;
        let mark = match series.style {
            Style::FaintMarks => Some(FAINT_MARK),
            Style::Marks | Style::LineAndMarks | Style::Steps => Some(MARK),
            _ => is_dot.then_some(MARK),
        };
        if let Some(radius) = mark {
            let marks = points().map(|point| Circle::new(point, radius, look.colour.filled()));
            plane.draw_series(marks)?;
        }
        let path: Vec<_> = match series.style {
            Style::Marks | Style::FaintMarks | Style::Remark => continue,
            Style::NamedLine => {
                let places = points().map(|point| plane.backend_coord(&point));
                hover.line(places, look.colour, LINE, &series.name);
                continue;
            }
            Style::Steps => steps(&piece),
            Style::Line | Style::LineAndMarks => points().collect(),
        };
        let stroke = look.colour.stroke_width(LINE);
        match look.dash {
            None => plane.draw_series([PathElement::new(path, stroke)])?,
            Some(dash) => {
                plane.draw_series([DashedPathElement::new(path, dash * DOT, GAP, stroke)])?
            }
        };
    }
    Ok(())
}

/// First along, then up or down.
fn steps(points: &[[f64; 2]]) -> Vec<(f64, f64)> {
    let mut path = Vec::with_capacity(2 * points.len());
    for (index, [x, y]) in points.iter().enumerate() {
        if let Some(before) = index.checked_sub(1) {
            path.push((*x, points[before][1]));
        }
        path.push((*x, *y));
    }
    path
}

/// A line `y = c xᵖ` as far as it lies between the axes, its name near its end.
fn reference<B: DrawingBackend>(
    plane: &mut Plane<B>,
    slope: &ReferenceSlope,
    x: &Ruler,
    y: &Ruler,
) -> Result<(), Failure<B>> {
    const PARTS: u32 = 200;
    let [x_start, x_end] = x.ends();
    let [x_through, y_through] = slope.through;
    let points: Vec<(f64, f64)> = (0..=PARTS)
        .map(|part| {
            let fraction = f64::from(part) / f64::from(PARTS);
            let at = match x.scale() {
                Scale::Linear => x_start + fraction * (x_end - x_start),
                Scale::Logarithmic => x_start * (x_end / x_start).powf(fraction),
            };
            (at, y_through * (at / x_through).powf(slope.exponent))
        })
        .filter(|(_, height)| y.contains(*height))
        .collect();
    let Some(&near_end) = points.get(points.len() * 19 / 20) else {
        return Ok(());
    };
    // Above the line, on the side where that doesn't come back to it.
    let side = if slope.exponent > 0.0 {
        HPos::Right
    } else {
        HPos::Left
    };
    let style = text_style(0.9 * FONT, &REFERENCE).pos(Pos::new(side, VPos::Bottom));
    let line = DashedPathElement::new(points, 6 * DOT, 4 * DOT, REFERENCE.stroke_width(THIN));
    plane.draw_series([line])?;
    plane.draw_series([Text::new(slope.name.clone(), near_end, style)])?;
    Ok(())
}

/// A line along an axis as marks that no label may hide.
fn stretch(from: (i32, i32), to: (i32, i32)) -> impl Iterator<Item = Mark> {
    let radius = LINE as i32;
    let length = (to.0 - from.0).abs().max((to.1 - from.1).abs());
    (0..=length).step_by(2 * radius as usize).map(move |way| {
        let part = f64::from(way) / f64::from(length.max(1));
        let between = |from: i32, to: i32| from + (part * f64::from(to - from)) as i32;
        Mark {
            at: (between(from.0, to.0), between(from.1, to.1)),
            radius,
        }
    })
}

/// Labels beside their points, where they hide neither each other nor a mark.
fn words<B: DrawingBackend>(
    chart: &Chart,
    plane: &mut Plane<B>,
    x: &Ruler,
    y: &Ruler,
) -> Result<(), Failure<B>> {
    let (along, up) = plane.plotting_area().get_pixel_range();
    let place = |[right, high]: [f64; 2]| {
        let is_shown = x.contains(right) && y.contains(high);
        is_shown.then(|| plane.backend_coord(&(right, high)))
    };
    let marked = (chart.series.iter()).filter(|series| !series.style.is_line());
    let mut marks: Vec<Mark> = (marked.flat_map(|series| {
        let radius = match series.style {
            Style::FaintMarks => FAINT_MARK,
            _ => MARK,
        };
        series.points.iter().map(move |point| (*point, radius))
    }))
    .filter_map(|(point, radius)| place(point).map(|at| Mark { at, radius }))
    .collect();
    let stepped = (chart.series.iter()).filter(|series| series.style == Style::Steps);
    for series in stepped {
        let corners = steps(&series.points).into_iter();
        let corners: Vec<(i32, i32)> = corners.filter_map(|(x, y)| place([x, y])).collect();
        marks.extend(
            corners
                .windows(2)
                .flat_map(|ends| stretch(ends[0], ends[1])),
        );
    }
    let labelled: Vec<(&str, (i32, i32))> = (chart.notes.iter())
        .filter(|note| !note.label.is_empty())
        .filter_map(|note| Some((note.label.as_str(), place(note.at)?)))
        .collect();
    let height = SMALLER * FONT;
    let wanted: Vec<Word> = (labelled.iter())
        .map(|(label, at)| {
            let width = label.chars().count() as f64 * CHARACTER * height;
            Word {
                at: *at,
                size: (width as i32, height as i32),
                distance: MARK + DOT as i32,
            }
        })
        .collect();
    let style = text_style(height, &INK).pos(Pos::new(HPos::Left, VPos::Top));
    let area = plane.plotting_area().strip_coord_spec();
    let origin = area.get_base_pixel();
    for ((label, _), corner) in labelled.iter().zip(placed(&wanted, &marks, (along, up))) {
        let Some((left, top)) = corner else {
            continue;
        };
        let corner = (left - origin.0, top - origin.1);
        area.draw(&Text::new((*label).to_owned(), corner, style.clone()))?;
    }
    Ok(())
}
