//! Charts as plain data; [`svg`](super::svg) draws one or several below each other.
//!
//! Text is left to the viewer's sans-serif font, so that nothing depends on the fonts of the machine that draws. Values that aren't
//! finite, or beyond 1e300, or not positive on a logarithmic axis, interrupt their line.

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
    /// Labels at points, and what is told of them.
    pub notes: Vec<Note>,
}

/// Quantity on an axis.
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
    /// A line through the points that stands out and says its name while the pointer is over it.
    NamedLine,
    /// A mark at each point, joined by steps: first along, then up or down.
    Steps,
    /// A small grey mark at each point, for what is in the background.
    FaintMarks,
    /// Nothing is drawn: the name is a remark in the legend.
    Remark,
}

impl Style {
    /// Whether it is a line and nothing else, such as a history.
    pub(super) fn is_line(self) -> bool {
        matches!(self, Self::Line | Self::NamedLine | Self::Remark)
    }
}

/// A thin dashed line `y = c xᵖ` through a point: on logarithmic axes, a slope.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceSlope {
    /// Label at its end, for example `h²`.
    pub name: String,
    /// p.
    pub exponent: f64,
    /// A point of the line, both coordinates positive.
    pub through: [f64; 2],
}

/// What is said of a point of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// Label beside the point; empty for none. It is left out where it would hide another label or a mark.
    pub label: String,
    /// Text that is shown while the pointer is over the point; empty for none.
    pub told: String,
    /// The point.
    pub at: [f64; 2],
}
