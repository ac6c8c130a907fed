//! Charts to SVG.

use std::io::Write as _;
use std::path::Path;

use plotters::chart::ChartContext;
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::element::{Circle, DashedPathElement, PathElement, Text};
use plotters::prelude::{
    Color, DrawingArea, DrawingBackend, IntoDrawingArea, IntoFont, RGBColor, SVGBackend, WHITE,
};
use plotters::style::TextStyle;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::axis::{Ends, Ruler};
use crate::chart::{Chart, ReferenceSlope, Scale, Style};
use crate::curve::pieces;
use crate::label_places::{Mark, Word, placed};
use dcb_formats::Error;
use dcb_formats::output::{Replace, write_stream};

/// Okabe and Ito's colours, which colour-blind readers tell apart; yellow is left out, being too pale on white.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];
const INK: RGBColor = RGBColor(40, 40, 40);
const GRID: RGBColor = RGBColor(222, 222, 222);
const REFERENCE: RGBColor = RGBColor(120, 120, 120);

/// So many steps has a drawing for a dot of the picture: the drawing's coordinates are whole numbers, and curves are smooth.
const DOT: u32 = 4;
/// Sizes in steps of the drawing; a picture is scaled to where it is shown.
const WIDTH: u32 = 960 * DOT;
const HEIGHT: u32 = 400 * DOT;
const SMALL_WIDTH: u32 = 560 * DOT;
const SMALL_HEIGHT: u32 = 320 * DOT;
const FONT: f64 = 18.0 * DOT as f64;
/// Words at points, by the font of everything else.
const SMALLER: f64 = 0.8;
/// Width of a character of a sans-serif font, in heights, on the safe side.
const CHARACTER: f64 = 0.5;
const MARGIN: u32 = 14 * DOT;
/// The sample of a line in the legend.
const SAMPLE: i32 = 28 * DOT as i32;
const LEGEND_LINE: i32 = 24 * DOT as i32;
const THIN: u32 = DOT;
const LINE: u32 = 2 * DOT;
const MARK: i32 = 4 * DOT as i32;
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
    draw(charts, (width, height), ticks, &mut svg).map_err(NotDrawn::Refused)?;
    let drawing = format!("width=\"{width}\" height=\"{height}\"");
    let shown = format!("width=\"{}\" height=\"{}\"", width / DOT, height / DOT);
    Ok(svg.replacen(&drawing, &shown, 1))
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
) -> Result<(), String> {
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
    for ((chart, rulers), area) in charts.iter().zip(rulers).zip(areas) {
        panel(chart, rulers, widths, &area).map_err(|error| told(&error))?;
    }
    root.present().map_err(|error| told(&error))
}

type Failure<B> = plotters::drawing::DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>;

/// Room left and right of the axes, the same for all charts of a picture: their axes are aligned.
#[derive(Clone, Copy)]
struct Widths {
    labels: u32,
    legend: u32,
}

fn text_width(characters: usize) -> u32 {
    (characters as f64 * CHARACTER * FONT) as u32
}

fn rulers(chart: &Chart, ticks: [usize; 2]) -> (Ruler, Ruler) {
    let values = |index: usize| {
        let points = chart.series.iter().flat_map(|series| &series.points);
        points.map(move |point| point[index])
    };
    let is_history = chart
        .series
        .iter()
        .all(|series| series.style == Style::Line);
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
        let style = look(index);
        for piece in pieces(&series.points, &x, &y) {
            let points = || piece.iter().map(|point| (point[0], point[1]));
            if series.style != Style::Line || piece.len() == 1 {
                let marks = points().map(|point| Circle::new(point, MARK, style.colour.filled()));
                plane.draw_series(marks)?;
            }
            if series.style != Style::Marks {
                let stroke = style.colour.stroke_width(LINE);
                let points: Vec<_> = points().collect();
                match style.dash {
                    None => plane.draw_series([PathElement::new(points, stroke)])?,
                    Some(dash) => {
                        plane.draw_series([DashedPathElement::new(points, dash, GAP, stroke)])?
                    }
                };
            }
        }
    }
    words(chart, &mut plane, &x, &y)?;
    if chart.series.len() > 1 {
        legend(chart, &legend_area)?;
    }
    Ok(())
}

/// Colour and dashes of a curve: after as many curves as there are colours, the dashes change.
#[derive(Clone, Copy)]
struct Look {
    colour: RGBColor,
    dash: Option<u32>,
}

const GAP: u32 = 5 * DOT;

fn look(index: usize) -> Look {
    let round = (index / COLOURS.len()) as u32;
    Look {
        colour: COLOURS[index % COLOURS.len()],
        dash: (round > 0).then(|| 12 * DOT / round.min(4)),
    }
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

/// The notes beside their points, where they hide neither each other nor a mark.
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
    let marked = (chart.series.iter()).filter(|series| series.style != Style::Line);
    let marks: Vec<Mark> = (marked.flat_map(|series| &series.points))
        .filter_map(|point| place(*point))
        .map(|at| Mark { at, radius: MARK })
        .collect();
    let height = SMALLER * FONT;
    let wanted: Vec<Word> = (chart.notes.iter())
        .filter_map(|note| {
            let width = note.text.chars().count() as f64 * CHARACTER * height;
            Some(Word {
                at: place(note.at)?,
                size: (width as i32, height as i32),
                distance: MARK + DOT as i32,
            })
        })
        .collect();
    let texts = (chart.notes.iter()).filter(|note| place(note.at).is_some());
    let style = text_style(height, &INK).pos(Pos::new(HPos::Left, VPos::Top));
    let area = plane.plotting_area().strip_coord_spec();
    let origin = area.get_base_pixel();
    for (note, corner) in texts.zip(placed(&wanted, &marks, (along, up))) {
        let Some((left, top)) = corner else {
            continue;
        };
        let corner = (left - origin.0, top - origin.1);
        area.draw(&Text::new(note.text.clone(), corner, style.clone()))?;
    }
    Ok(())
}

fn legend_width(chart: &Chart) -> u32 {
    let names = chart
        .series
        .iter()
        .map(|series| series.name.chars().count());
    match names.max() {
        Some(longest) if chart.series.len() > 1 => text_width(longest) + SAMPLE as u32 + 2 * MARGIN,
        _ => 0,
    }
}

/// Names beside the axes, where they hide nothing.
fn legend<B: DrawingBackend>(
    chart: &Chart,
    area: &DrawingArea<B, Shift>,
) -> Result<(), Failure<B>> {
    let style = text_style(FONT, &INK).pos(Pos::new(HPos::Left, VPos::Center));
    for (index, series) in chart.series.iter().enumerate() {
        let look = look(index);
        let height = 2 * MARGIN as i32 + LEGEND_LINE * index as i32;
        let ends = [(0, height), (SAMPLE, height)];
        let stroke = look.colour.stroke_width(LINE);
        match (series.style, look.dash) {
            (Style::Marks, _) => {}
            (_, None) => area.draw(&PathElement::new(ends, stroke))?,
            (_, Some(dash)) => area.draw(&DashedPathElement::new(ends, dash, GAP, stroke))?,
        }
        if series.style != Style::Line {
            area.draw(&Circle::new(
                (SAMPLE / 2, height),
                MARK,
                look.colour.filled(),
            ))?;
        }
        let place = (SAMPLE + 8 * DOT as i32, height);
        area.draw(&Text::new(series.name.clone(), place, style.clone()))?;
    }
    Ok(())
}

fn text_style(size: f64, colour: &RGBColor) -> TextStyle<'_> {
    TextStyle::from(("sans-serif", size).into_font()).color(colour)
}
