//! Numbers as Matrix Market files spell them, read from the front of a byte slice.
//!
//! Each function returns the number and how many bytes it took; the caller sees to what must follow. Anything that established
//! readers cut off silently (`1.5+103`, `1.5D+03`, `0x10`) is either understood or left over, so that the caller refuses it.

/// Why the front of a slice is not the number wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotANumber {
    /// Other characters.
    Unreadable,
    /// More digits than 64 bits hold.
    OutOfRange,
    /// NaN, infinite, or beyond f64.
    NotFinite,
}

/// Digits at the front of eight bytes: their number and how many they are.
#[inline(always)]
fn leading_digits(bytes: [u8; 8]) -> (u64, usize) {
    const LOW: u64 = 0x7f7f_7f7f_7f7f_7f7f;
    // Digits become 0 to 9; the top bit of a byte tells what isn't one.
    let values = u64::from_le_bytes(bytes) ^ 0x3030_3030_3030_3030;
    let others = (((values & LOW) + 0x7676_7676_7676_7676) | values) & !LOW;
    let length = others.trailing_zeros() / 8;
    // The last digit to the top byte, zeros before the first; then pairs, fours and eights of digits.
    let digits = values.checked_shl(64 - 8 * length).unwrap_or(0);
    let pairs = (10 * digits + (digits >> 8)) & 0x00ff_00ff_00ff_00ff;
    let fours = (100 * pairs + (pairs >> 16)) & 0x0000_ffff_0000_ffff;
    let value = (10_000 * fours + (fours >> 32)) & 0xffff_ffff;
    (value, length as usize)
}

/// Unsigned decimal integer.
#[inline(always)]
pub fn unsigned(text: &[u8]) -> Result<(u64, usize), NotANumber> {
    if let Some(bytes) = text.first_chunk() {
        let (value, length) = leading_digits(*bytes);
        if (1..8).contains(&length) {
            return Ok((value, length));
        }
    }
    unsigned_of_any_length(text)
}

fn unsigned_of_any_length(text: &[u8]) -> Result<(u64, usize), NotANumber> {
    let mut value = 0u64;
    let mut length = 0;
    for &byte in text {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        // 18 digits always fit.
        value = if length < 18 {
            value * 10 + u64::from(digit)
        } else {
            value
                .checked_mul(10)
                .and_then(|value| value.checked_add(u64::from(digit)))
                .ok_or(NotANumber::OutOfRange)?
        };
        length += 1;
    }
    if length == 0 {
        Err(NotANumber::Unreadable)
    } else {
        Ok((value, length))
    }
}

/// Decimal integer with an optional sign, within 64 bits, rounded to f64.
pub fn integer(text: &[u8]) -> Result<(f64, usize), NotANumber> {
    let sign_length = usize::from(matches!(text.first(), Some(b'+' | b'-')));
    let (magnitude, length) = unsigned(&text[sign_length..])?;
    let value = if text.first() == Some(&b'-') {
        -(magnitude as f64)
    } else {
        magnitude as f64
    };
    Ok((value, sign_length + length))
}

/// Longest spelling with a D exponent that is understood: sign, 17 digits and more than enough zeros, exponent.
const D_EXPONENT_LENGTH: usize = 80;

/// Finite decimal number; the exponent letter may be `e`, `E`, and Fortran's `d`, `D`.
#[inline(always)]
pub fn real(text: &[u8]) -> Result<(f64, usize), NotANumber> {
    let (value, length) =
        fast_float2::parse_partial::<f64, _>(text).map_err(|_| NotANumber::Unreadable)?;
    if matches!(text.get(length), Some(b'd' | b'D')) {
        return real_with_d_exponent(text, length);
    }
    if value.is_finite() {
        Ok((value, length))
    } else {
        Err(NotANumber::NotFinite)
    }
}

#[cold]
fn real_with_d_exponent(text: &[u8], letter_at: usize) -> Result<(f64, usize), NotANumber> {
    let mut spelling = [0u8; D_EXPONENT_LENGTH];
    let length = text.len().min(D_EXPONENT_LENGTH);
    spelling[..length].copy_from_slice(&text[..length]);
    *spelling.get_mut(letter_at).ok_or(NotANumber::Unreadable)? = b'E';
    let (value, length) = fast_float2::parse_partial::<f64, _>(&spelling[..length])
        .map_err(|_| NotANumber::Unreadable)?;
    if length <= letter_at + 1 || length == D_EXPONENT_LENGTH {
        return Err(NotANumber::Unreadable);
    }
    if value.is_finite() {
        Ok((value, length))
    } else {
        Err(NotANumber::NotFinite)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    #[test]
    fn reals_in_every_spelling() {
        for (text, value) in [
            ("1.5", 1.5),
            (".5", 0.5),
            ("5.", 5.0),
            ("+2.5e+1", 25.0),
            ("1E3", 1000.0),
            ("1.5D+03", 1500.0),
            ("-2.5d-01", -0.25),
            ("1d2", 100.0),
            ("1e-320", 1e-320),
            ("8589934592", 8_589_934_592.0),
        ] {
            assert_eq!(real(text.as_bytes()), Ok((value, text.len())), "{text}");
        }
    }

    #[test]
    fn what_is_not_a_real_is_left_over_or_refused() {
        for text in [
            "1.5+103", "0x10", "1.5e", "1,5", "1.5F3", "1.5D", "1.5D+", "1.5Dx", "e5", "", "-",
            ".", "+-1",
        ] {
            let read = real(text.as_bytes());
            assert!(
                !matches!(read, Ok((_, length)) if length == text.len()),
                "{text}: {read:?}"
            );
        }
        for text in ["nan", "inf", "-Infinity", "1e310", "1d999"] {
            assert_eq!(real(text.as_bytes()), Err(NotANumber::NotFinite), "{text}");
        }
    }

    #[test]
    fn integers_of_every_length_end_where_the_digits_do() {
        for digits in [
            "7",
            "09",
            "123",
            "4567",
            "89012",
            "345678",
            "9012345",
            "67890123",
            "456789012",
        ] {
            for after in [
                "",
                " ",
                "\n",
                "\t1",
                "/",
                ":",
                "x99999999",
                "\u{e9}1234567",
                " 12345678",
            ] {
                let read = unsigned(format!("{digits}{after}").as_bytes());
                let expected = (digits.parse().unwrap_or(0), digits.len());
                assert_eq!(read, Ok(expected), "{digits}{after}");
            }
        }
    }

    #[test]
    fn integers_stop_at_64_bits() {
        assert_eq!(unsigned(b"18446744073709551615 "), Ok((u64::MAX, 20)));
        assert_eq!(
            unsigned(b"18446744073709551616"),
            Err(NotANumber::OutOfRange)
        );
        assert_eq!(integer(b"-12 "), Ok((-12.0, 3)));
        assert_eq!(integer(b"+x"), Err(NotANumber::Unreadable));
    }
}
