//! Colours and dashes of curves and marks.

use plotters::style::RGBColor;

use crate::chart::Style;

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
/// Of marks in the background.
const FAINT: RGBColor = RGBColor(150, 150, 150);

/// Colour and dashes of a curve: after as many curves as there are colours, the dashes change.
#[derive(Clone, Copy)]
pub(super) struct Look {
    pub(super) colour: RGBColor,
    /// Length of a dash in dots.
    pub(super) dash: Option<u32>,
}

/// The look of the series at `index`.
pub(super) fn look(index: usize, style: Style) -> Look {
    if style == Style::FaintMarks {
        return Look {
            colour: FAINT,
            dash: None,
        };
    }
    let round = (index / COLOURS.len()) as u32;
    Look {
        colour: COLOURS[index % COLOURS.len()],
        dash: (round > 0).then(|| 12 / round.min(4)),
    }
}
