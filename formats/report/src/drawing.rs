//! What all parts of a drawing share: its steps, sizes, ink and words.

use plotters::prelude::{DrawingBackend, IntoFont, RGBColor};
use plotters::style::TextStyle;

/// So many steps has a drawing for a dot of the picture: the drawing's coordinates are whole numbers, and curves are smooth.
pub(super) const DOT: u32 = 4;
pub(super) const FONT: f64 = 18.0 * DOT as f64;
/// Width of a character of a sans-serif font, in heights, on the safe side.
pub(super) const CHARACTER: f64 = 0.5;
pub(super) const MARGIN: u32 = 14 * DOT;
pub(super) const LINE: u32 = 2 * DOT;
pub(super) const MARK: i32 = 4 * DOT as i32;
pub(super) const FAINT_MARK: i32 = 3 * DOT as i32;
pub(super) const GAP: u32 = 5 * DOT;
pub(super) const INK: RGBColor = RGBColor(40, 40, 40);

/// Why a part isn't drawn.
pub(super) type Failure<B> =
    plotters::drawing::DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>;

/// Width of a text, on the safe side.
pub(super) fn text_width(characters: usize) -> u32 {
    (characters as f64 * CHARACTER * FONT) as u32
}

pub(super) fn text_style(size: f64, colour: &RGBColor) -> TextStyle<'_> {
    TextStyle::from(("sans-serif", size).into_font()).color(colour)
}
