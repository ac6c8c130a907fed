//! What answers to the pointer in a picture: a title that the browser shows, and a mark or a line that stands out. No script.
//!
//! The plotting library knows nothing of it, so these elements are written as text and put over its drawing.

use std::fmt::Write as _;

use plotters::style::RGBColor;

use crate::html::escaped;

/// Rules for the elements below; a page may have them once for each picture.
const STYLE: &str = "<style>.chart-mark{fill-opacity:0;stroke-opacity:0}.chart-mark:hover{stroke-opacity:.45}\
.chart-line:hover{stroke-width:20}</style>\n";

/// Elements over a drawing.
#[derive(Default)]
pub(super) struct Hover {
    elements: String,
}

impl Hover {
    /// A ring around a mark that is seen while the pointer is over it.
    pub(super) fn mark(&mut self, (x, y): (i32, i32), radius: i32, told: &str) {
        // Writing to a string doesn't fail.
        let _ = writeln!(
            self.elements,
            "<circle class=\"chart-mark\" cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"#000\" stroke=\"#000\" stroke-width=\"{radius}\"><title>{}</title></circle>",
            escaped(told)
        );
    }

    /// A line with its name.
    pub(super) fn line(
        &mut self,
        points: impl Iterator<Item = (i32, i32)>,
        colour: RGBColor,
        width: u32,
        name: &str,
    ) {
        let mut places = String::new();
        for (x, y) in points {
            let _ = write!(places, "{x},{y} ");
        }
        let RGBColor(red, green, blue) = colour;
        let _ = writeln!(
            self.elements,
            "<polyline class=\"chart-line\" fill=\"none\" stroke=\"#{red:02X}{green:02X}{blue:02X}\" stroke-width=\"{width}\" points=\"{}\"><title>{}</title></polyline>",
            places.trim_end(),
            escaped(name)
        );
    }

    /// The drawing with these elements over it.
    pub(super) fn over(&self, mut svg: String) -> String {
        if let (false, Some(end)) = (self.elements.is_empty(), svg.rfind("</svg>")) {
            svg.insert_str(end, &format!("{STYLE}{}", self.elements));
        }
        svg
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_escaped_and_a_drawing_without_any_stays_as_it_is() {
        let drawing = "<svg>\n<g/>\n</svg>\n";
        assert_eq!(Hover::default().over(drawing.to_owned()), drawing);
        let mut hover = Hover::default();
        hover.mark((3, 4), 16, "<script> & \"row\" 1");
        hover.line(
            [(0, 0), (8, 4)].into_iter(),
            RGBColor(0, 114, 178),
            8,
            "a<b",
        );
        let svg = hover.over(drawing.to_owned());
        assert!(svg.contains("<title>&lt;script&gt; &amp; &quot;row&quot; 1</title></circle>"));
        assert!(svg.contains("stroke=\"#0072B2\"") && svg.contains("points=\"0,0 8,4\""));
        assert!(svg.contains("<title>a&lt;b</title></polyline>"));
        assert!(svg.starts_with("<svg>\n<g/>\n<style>") && svg.ends_with("</svg>\n"));
    }
}
