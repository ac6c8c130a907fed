//! What stands in the fields of a card: labels, components and numbers.

use dcb_formats::matrix::blocks::{NotANumber, shown, unsigned};

use crate::stored::LARGEST_LABEL;
use crate::stored::row_key::{RowKey, direction};
use crate::text::real::{Digits, significant, whole_real};

/// An unsigned integer that fills a field.
#[inline]
pub(super) fn integer(field: &[u8]) -> Option<u64> {
    match unsigned(field) {
        Ok((value, length)) if length == field.len() => Some(value),
        _ => None,
    }
}

/// The row of a grid and its component, or of a scalar point, which has component 0 or none.
///
/// # Errors
/// Labels beyond 31 bits, components that aren't directions.
#[inline]
pub(super) fn row(label: &[u8], component: &[u8]) -> Result<RowKey, String> {
    let point = match unsigned(label) {
        Ok((value, length))
            if length == label.len() && (1..=u64::from(LARGEST_LABEL)).contains(&value) =>
        {
            value as u32
        }
        _ => return Err(no_label(label)),
    };
    match component {
        b"" | b"0" => Ok(RowKey::internal(point, 0)),
        [digit @ b'1'..=b'6'] => match direction(u64::from(digit - b'0')) {
            Some(direction) => Ok(RowKey::nodal(point, direction)),
            None => Err(no_component(point, component)),
        },
        _ => Err(no_component(point, component)),
    }
}

#[cold]
fn no_label(label: &[u8]) -> String {
    let number = shown(label);
    match unsigned(label) {
        Ok((1.., length)) | Ok((_, length)) if length == label.len() && label != b"0" => {
            format!(
                "the label {number}; labels are at most {LARGEST_LABEL}, number the points anew"
            )
        }
        Err(NotANumber::OutOfRange) => {
            format!(
                "the label {number}; labels are at most {LARGEST_LABEL}, number the points anew"
            )
        }
        _ => format!("`{number}`; expected the label of a grid or scalar point"),
    }
}

#[cold]
fn no_component(point: u32, component: &[u8]) -> String {
    format!(
        "component `{}` of point {point}; expected one of 1 to 6, or 0 for a scalar point",
        shown(component)
    )
}

/// Binary orders of magnitude below the largest number in which digits count: a factor of a thousand.
const ORDERS: usize = 10;

/// Significant digits that numbers are printed with. Numbers that fill their field had no room for more: the fewest digits of those count,
/// as far as they are within a thousandth of the largest number, because round-off beside it has few digits and does no harm. Where
/// commas end fields, the number with the most digits counts.
#[derive(Clone, Debug)]
pub(super) struct FieldDigits {
    /// By the binary order of magnitude; 0 where there is none.
    fewest: Box<[u8; 1 << 11]>,
    free: Digits,
}

impl Default for FieldDigits {
    fn default() -> Self {
        Self {
            fewest: Box::new([0; 1 << 11]),
            free: Digits::default(),
        }
    }
}

impl FieldDigits {
    #[inline]
    fn see(&mut self, number: &[u8], value: f64, width: Option<usize>) {
        match width {
            None => self.free.see(number),
            // A column stays free for the sign.
            Some(width) if number.len() + 1 >= width => {
                let order = (value.abs().to_bits() >> (f64::MANTISSA_DIGITS - 1)) as usize;
                lower(&mut self.fewest[order], significant(number) as u8);
            }
            Some(_) => {}
        }
    }

    /// Takes those of other numbers in.
    pub(super) fn join(&mut self, other: &Self) {
        for (own, count) in self.fewest.iter_mut().zip(*other.fewest) {
            lower(own, count);
        }
        self.free.join(other.free);
    }

    /// Their number; `None` where every number had room for more.
    pub(super) fn count(&self) -> Option<u32> {
        let largest = self.fewest.iter().rposition(|count| *count > 0);
        let counts = largest.map(|order| &self.fewest[order.saturating_sub(ORDERS)..]);
        let fewest = counts.and_then(|counts| counts.iter().filter(|count| **count > 0).min());
        fewest.copied().map(u32::from).or(self.free.count())
    }
}

/// The lower of two counts, of which 0 is none.
#[inline]
fn lower(own: &mut u8, other: u8) {
    if other > 0 && (*own == 0 || other < *own) {
        *own = other;
    }
}

/// The real number in a field of so many columns. It has a point: what has none isn't where numbers are.
///
/// # Errors
/// Something else stands there.
#[inline]
pub(super) fn real(
    field: &[u8],
    width: Option<usize>,
    digits: &mut FieldDigits,
) -> Result<f64, String> {
    match whole_real(field) {
        Ok(value) if field.contains(&b'.') => {
            if value != 0.0 {
                digits.see(field, value, width);
            }
            Ok(value)
        }
        Err(NotANumber::NotFinite) => Err(format!("`{}`; expected a finite number", shown(field))),
        _ => Err(format!(
            "`{}`; expected a number with a point, such as 1.5, 1.5+3 or 1.5D+03",
            shown(field)
        )),
    }
}
