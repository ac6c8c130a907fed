//! Fortran formats of numbers in fixed columns: `(10I8)`, `(1P,3E25.16)`, `(4D20.12)`.

use dcb_formats::matrix::blocks::shown;

/// Longest field.
const MOST_WIDTH: usize = 64;
/// Most fields of a line.
const MOST_FIELDS: usize = 1 << 12;

/// A format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Format {
    /// Fields of a line.
    pub(super) fields: usize,
    /// Characters of a field.
    pub(super) width: usize,
    /// Places behind the point, which a number without one has all the same; `None` for integers.
    decimals: Option<usize>,
    /// Whether a number without exponent would be divided by a power of ten.
    is_scaled: bool,
}

impl Format {
    /// Of numbers that aren't read.
    pub(super) const UNUSED: Self = Self {
        fields: 1,
        width: 1,
        decimals: None,
        is_scaled: false,
    };

    /// `None` for text that is no such format.
    pub(super) fn of(text: &[u8]) -> Option<Self> {
        let text: Vec<u8> = text
            .iter()
            .filter(|byte| !byte.is_ascii_whitespace())
            .map(u8::to_ascii_uppercase)
            .collect();
        let mut rest = text.strip_prefix(b"(")?.strip_suffix(b")")?;
        let mut is_scaled = false;
        let sign = usize::from(matches!(rest.first(), Some(b'+' | b'-')));
        let (scale, behind) = number(&rest[sign..]);
        if let Some(behind) = behind.strip_prefix(b"P") {
            is_scaled = scale? != 0;
            rest = behind.strip_prefix(b",").unwrap_or(behind);
        }
        let (fields, behind) = number(rest);
        let (kind, behind) = behind.split_first()?;
        let (width, behind) = number(behind);
        let (decimals, behind) = match behind.strip_prefix(b".") {
            Some(decimals) => number(decimals),
            None => (None, behind),
        };
        // Digits of the exponent, as in `E25.16E3`.
        let behind = match behind.strip_prefix(b"E") {
            Some(digits) => number(digits).1,
            None => behind,
        };
        let decimals = match kind {
            b'I' => None,
            b'E' | b'D' | b'F' | b'G' => Some(decimals?),
            _ => return None,
        };
        let format = Self {
            fields: fields.unwrap_or(1),
            width: width?,
            decimals,
            is_scaled,
        };
        let is_sound = behind.is_empty()
            && (1..=MOST_WIDTH).contains(&format.width)
            && (1..=MOST_FIELDS).contains(&format.fields);
        is_sound.then_some(format)
    }

    /// Whether it is for integers.
    pub(super) fn is_integer(&self) -> bool {
        self.decimals.is_none()
    }

    /// Refuses numbers that Fortran would multiply by a power of ten, which other programs don't: without a point, or without an
    /// exponent under a scale factor.
    pub(super) fn check(&self, field: &[u8]) -> Result<(), String> {
        let length = field.len();
        let is_letter = |byte: &u8| matches!(byte, b'e' | b'E' | b'd' | b'D');
        let has_usual_exponent = length > 4 && is_letter(&field[length - 4]);
        if field.iter().take(3).any(|byte| *byte == b'.') && (has_usual_exponent || !self.is_scaled)
        {
            return Ok(());
        }
        self.check_thoroughly(field)
    }

    #[cold]
    fn check_thoroughly(&self, field: &[u8]) -> Result<(), String> {
        if field.iter().all(|byte| !matches!(byte, b'1'..=b'9')) {
            return Ok(());
        }
        let has_point = field.iter().any(|byte| matches!(byte, b'.' | b','));
        if !has_point && self.decimals.is_some_and(|decimals| decimals > 0) {
            return Err(format!(
                "`{}` has no point; programs don't agree where it belongs",
                shown(field)
            ));
        }
        let has_exponent = field.iter().enumerate().any(|(place, byte)| {
            matches!(byte, b'e' | b'E' | b'd' | b'D') || (place > 0 && matches!(byte, b'+' | b'-'))
        });
        match self.is_scaled && !has_exponent {
            true => Err(format!(
                "`{}` has no exponent, and the scale factor of the format would change it",
                shown(field)
            )),
            false => Ok(()),
        }
    }
}

/// A number in front, and what comes behind it.
fn number(text: &[u8]) -> (Option<usize>, &[u8]) {
    let length = text.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let (digits, rest) = text.split_at(length);
    let digits = std::str::from_utf8(digits).unwrap_or_default();
    // More digits than a number has are too many in any place.
    let number = (length > 0).then(|| digits.parse().unwrap_or(usize::MAX));
    (number, rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn format(text: &str) -> Option<(usize, usize, Option<usize>, bool)> {
        let format = Format::of(text.as_bytes())?;
        Some((
            format.fields,
            format.width,
            format.decimals,
            format.is_scaled,
        ))
    }

    #[test]
    fn formats_of_fortran_are_understood_in_every_spelling() {
        for (text, expected) in [
            ("(10I8)", (10, 8, None, false)),
            ("(1I14)", (1, 14, None, false)),
            ("(I14)", (1, 14, None, false)),
            ("(1P,3E25.16)", (3, 25, Some(16), true)),
            ("(1P3E25.16E3)", (3, 25, Some(16), true)),
            ("( 1p , 3 e 25.16 )", (3, 25, Some(16), true)),
            ("(0P,4D20.12)", (4, 20, Some(12), false)),
            ("(1D25.15)", (1, 25, Some(15), false)),
            ("(8F10.3)", (8, 10, Some(3), false)),
            ("(-2P,G15.6)", (1, 15, Some(6), true)),
        ] {
            assert_eq!(format(text), Some(expected), "{text}");
        }
        for text in [
            "",
            "()",
            "(I)",
            "(10I)",
            "(E25)",
            "(4(1X,E19.12))",
            "(10I0)",
            "(0I8)",
            "(99999I8)",
            "(10I8",
            "10I8",
            "(3A8)",
            "(3E25.16,I4)",
            "(99999999999999999999I8)",
        ] {
            assert_eq!(format(text), None, "{text}");
        }
    }

    #[test]
    fn numbers_that_fortran_would_scale_are_refused() {
        let check = |text: &str, field: &str| {
            Format::of(text.as_bytes()).map(|format| format.check(field.as_bytes()).is_ok())
        };
        for (text, field, is_fine) in [
            ("(3E25.16)", "1.5", true),
            ("(3E25.16)", "15", false),
            ("(3E25.16)", "0", true),
            ("(3E25.16)", "1,5", true),
            ("(3F25.0)", "15", true),
            ("(1P,3E25.16)", "1.5E+03", true),
            ("(1P,3E25.16)", "1.5+3", true),
            ("(1P,3E25.16)", "-1.5", false),
            ("(1P,3E25.16)", "0.0", true),
        ] {
            assert_eq!(check(text, field), Some(is_fine), "{text} {field}");
        }
    }
}
