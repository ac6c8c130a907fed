//! Numbers in the fields of a line, as Fortran programs print and read them.

use dcb_formats::matrix::blocks::{self, NotANumber};
use dcb_formats::terminal::shortened;

use crate::stored::LARGEST_LABEL;
use crate::text::real::whole_real;

/// A field for a message.
pub(super) fn shown(field: &[u8]) -> String {
    format!("`{}`", shortened(&String::from_utf8_lossy(field)))
}

/// A finite number, spelt as [`whole_real`] says: `1.5D-03` and `1.5-3` too.
///
/// # Errors
/// What the field is instead.
pub(super) fn real(field: &[u8]) -> Result<f64, String> {
    whole_real(field).map_err(|error| match error {
        NotANumber::NotFinite => format!("{} is not finite", shown(field)),
        _ => format!("{} is no number", shown(field)),
    })
}

/// A whole number.
///
/// # Errors
/// What the field is instead.
pub(super) fn integer(field: &[u8]) -> Result<i64, String> {
    let digits = field.strip_prefix(b"-").or(field.strip_prefix(b"+"));
    let digits = digits.unwrap_or(field);
    let value = match blocks::unsigned(digits) {
        Ok((value, length)) if length == digits.len() => i64::try_from(value).ok(),
        Err(NotANumber::OutOfRange) => None,
        _ => return Err(format!("{} is no whole number", shown(field))),
    };
    let Some(value) = value else {
        return Err(format!("{} is beyond any label", shown(field)));
    };
    Ok(match field.first() {
        Some(b'-') => -value,
        _ => value,
    })
}

/// A label of a node or an element.
///
/// # Errors
/// What the field is instead, with the range of labels.
pub(super) fn label(field: &[u8]) -> Result<u32, String> {
    as_label(integer(field)?)
}

/// A whole number as a label.
///
/// # Errors
/// The number and the range.
pub(super) fn as_label(number: i64) -> Result<u32, String> {
    match u32::try_from(number) {
        Ok(label @ 1..=LARGEST_LABEL) => Ok(label),
        _ => Err(format!(
            "{number} is no label; labels go from 1 to {LARGEST_LABEL}"
        )),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn labels_have_a_range() {
        assert_eq!(label(b"2147483647"), Ok(2_147_483_647));
        for text in ["2147483648", "0", "-3", "99999999999999999999", "3.0", ""] {
            assert!(label(text.as_bytes()).is_err(), "{text}");
        }
        assert!(
            label(b"2147483648")
                .unwrap_err()
                .contains("2147483648 is no label")
        );
    }
}
