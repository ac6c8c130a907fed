//! Headers of ASCII files, and how the numbers behind them are printed.

use crate::matrix::nastran::op4::Header;

/// Characters of the name of a matrix.
const NAME: usize = 8;
/// Characters of columns, rows, form and type.
const INTEGERS: [[usize; 4]; 3] = [[8; 4], [16, 16, 8, 8], [16; 4]];
/// Widths that a field of a number with an exponent can have.
const WIDTHS: std::ops::RangeInclusive<usize> = 8..=64;

/// The first line of a matrix.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct TextHeader {
    pub(super) matrix: Header,
    pub(super) format: Format,
}

/// How numbers are printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Format {
    /// Characters of a number.
    pub(super) width: usize,
    /// Where the point is in a field with an exponent of four characters.
    pub(super) point: usize,
    /// Significant digits.
    pub(super) digits: u32,
}

impl TextHeader {
    /// Of a line; `None` where it isn't a header at all. Without a format, and perhaps a name, it is that of `5E16.9`.
    pub(super) fn of(line: &[u8]) -> Option<Result<Self, String>> {
        INTEGERS.iter().find_map(|widths| {
            let sizes = widths.iter().sum::<usize>();
            let rest = line.get(sizes..)?;
            let (name, format) = rest.split_at(rest.len().min(NAME));
            let format = match format.trim_ascii() {
                b"" if *widths == INTEGERS[0] => Format::USUAL,
                format => Format::of(format)?,
            };
            let mut integers = [0; 4];
            let mut at = 0;
            for (integer, width) in integers.iter_mut().zip(widths) {
                *integer = signed(&line[at..at + width])?;
                at += width;
            }
            let matrix = Header::new(integers, name);
            Some(matrix.map(|matrix| Self { matrix, format }))
        })
    }
}

impl Format {
    /// `1P,5E16.9`.
    const USUAL: Self = Self {
        width: 16,
        point: 2,
        digits: 10,
    };

    /// `1P,3E23.16` or the like, perhaps with `|I16` behind it.
    fn of(text: &[u8]) -> Option<Self> {
        let text = text.to_ascii_uppercase();
        let text = text.strip_suffix(b"|I16").unwrap_or(&text);
        let (text, is_scaled) = match text.strip_prefix(b"1P") {
            Some(rest) => (rest.strip_prefix(b",").unwrap_or(rest), true),
            None => (text, false),
        };
        let mut parts = text.split(|byte| matches!(byte, b'D' | b'E' | b'.'));
        let mut part = || unsigned(parts.next()?);
        let (_, width, decimals) = (part()?, part()?, part()?);
        let is_whole = parts.next().is_none();
        // A digit or sign, the point, and four characters of exponent.
        let point = width.checked_sub(decimals + 5).filter(|point| *point > 0)?;
        (WIDTHS.contains(&width) && is_whole).then_some(Self {
            width,
            point,
            digits: decimals as u32 + u32::from(is_scaled),
        })
    }
}

/// An integer of few digits.
fn unsigned(text: &[u8]) -> Option<usize> {
    (text.len() <= 4)
        .then(|| str::from_utf8(text).ok()?.parse().ok())
        .flatten()
}

/// The integer that fills a field from the right.
pub(super) fn signed(field: &[u8]) -> Option<i64> {
    str::from_utf8(field.trim_ascii_start()).ok()?.parse().ok()
}
